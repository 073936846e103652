"""``frangible verify``: measure what is promised."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from ..bench.verification import Verdict, as_json, table_head, table_rows, verify
from .options import EXIT_FAILED


def add_verify(commands: Any) -> None:
    """Add the command."""
    verifier = commands.add_parser(
        "verify", help="measure what the paper and we promise; status 1 if something does not hold"
    )
    verifier.set_defaults(command=_verify)
    verifier.add_argument(
        "claims", nargs="*", metavar="CLAIM", help="names from the table's first column [all]"
    )
    verifier.add_argument(
        "--json", action="store_true", help="one JSON object instead of the table"
    )


def _verify(options: argparse.Namespace) -> int:
    def say(*lines: str) -> None:
        if not options.json:
            print("\n".join(lines), flush=True)

    # The table grows as claims are measured.
    verdicts: list[Verdict] = []
    for verdict in verify(*options.claims, on_done=_print_verdict):
        say(*([] if verdicts else table_head()), *table_rows(verdict))
        verdicts.append(verdict)
    if options.json:
        print(json.dumps(as_json(verdicts), allow_nan=False))
    return 0 if all(verdict.holds for verdict in verdicts) else EXIT_FAILED


def _print_verdict(verdict: Verdict) -> None:
    result = "holds" if verdict.holds else "does not hold"
    print(
        f"{verdict.claim} {result}, measured in {verdict.seconds:.3g} s",
        file=sys.stderr,
        flush=True,
    )
