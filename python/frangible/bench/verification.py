"""The claims of the paper and ours, measured on this machine."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from dataclasses import asdict, dataclass
from threading import Thread
from typing import Any, TypedDict

from .. import _frangible
from ..words import did_you_mean

#: Claims that are measured at a time. Each has one thread, so that those that measure time have a
#: core of their own.
AT_A_TIME = 2
#: Of the table's columns, so that it can be read as it grows; what is longer sticks out.
WIDTHS = (14, 16, 78, 14, 16, 0)


class ClaimError(ValueError):
    """A claim that nobody makes, in one sentence."""


class Finding(TypedDict):
    """One measured number and the bounds that it is held to."""

    #: What was measured.
    quantity: str
    #: SI; ``1`` for a ratio.
    unit: str
    measured: float
    #: The least that holds; infinite for no bound.
    low: float
    #: The most that holds.
    high: float
    #: Whether it lies within its bounds; what is not a number does not.
    holds: bool
    #: Whether it has any; without, it stands beside the others.
    bounded: bool


@dataclass(frozen=True, slots=True)
class Verdict:
    """A claim, and what was found."""

    claim: str
    #: What is promised, in one line.
    says: str
    #: Who says so.
    source: str
    findings: list[Finding]
    #: That it took to measure [s].
    seconds: float

    @property
    def holds(self) -> bool:
        """Whether all findings do."""
        return all(finding["holds"] for finding in self.findings)

    def __repr__(self) -> str:
        return f"<Verdict on {self.claim!r}: {_judged(self.holds)}, {len(self.findings)} findings>"


def verify(*claims: str, on_done: Callable[[Verdict], None] | None = None) -> Iterator[Verdict]:
    """Measure claims, or all there are, side by side; `ClaimError` for an unknown name.

    Answers with each in order, and calls ``on_done`` with each as soon as it is measured.
    """
    known = {claim[0]: claim for claim in _frangible.claims()}
    for name in claims:
        if name not in known:
            raise ClaimError(
                f"unknown claim {name!r}, must be one of: "
                f"{', '.join(known)}{did_you_mean(name, known)}"
            )

    # Each thread takes the next claim that no other has taken.
    verdicts: list[Future[Verdict]] = [Future() for _ in claims or known]
    waiting = iter(
        [(*known[name], verdict) for name, verdict in zip(claims or known, verdicts, strict=True)]
    )

    def work() -> None:
        for name, says, source, future in waiting:
            try:
                begin = time.perf_counter()
                findings = _frangible.check_claim(name)
                verdict = Verdict(name, says, source, findings, time.perf_counter() - begin)
                if on_done is not None:
                    on_done(verdict)
                future.set_result(verdict)
            except BaseException as error:
                future.set_exception(error)

    # Nothing stops a claim half way, so one that nobody waits for any more must not keep the
    # process alive.
    for _ in range(min(AT_A_TIME, os.cpu_count() or 1)):
        Thread(target=work, daemon=True).start()
    return (verdict.result() for verdict in verdicts)


def table_head() -> list[str]:
    """The first lines of a Markdown table of verdicts."""
    return [
        _row("claim", "source", "quantity", "measured", "bound", "verdict"),
        _row(*["---"] * len(WIDTHS)),
    ]


def table_rows(verdict: Verdict) -> list[str]:
    """Its other lines: one for a claim, followed by one for each finding."""
    rows = [_row(verdict.claim, verdict.source, verdict.says, "", "", _judged(verdict.holds))]
    for finding in verdict.findings:
        judged = _judged(finding["holds"]) if finding["bounded"] else "(beside)"
        rows.append(_row("", "", finding["quantity"], _measured(finding), _bound(finding), judged))
    return rows


def as_json(verdicts: Iterable[Verdict]) -> dict[str, Any]:
    """The verdicts as what JSON can say: `None` for no bound, and for a measurement that is not a
    finite number."""
    claims = [{**asdict(verdict), "holds": verdict.holds} for verdict in verdicts]
    for claim in claims:
        for finding in claim["findings"]:
            for key in ("measured", "low", "high"):
                finding[key] = finding[key] if math.isfinite(finding[key]) else None
    return {"holds": all(claim["holds"] for claim in claims), "claims": claims}


def _row(*cells: str) -> str:
    return (
        "| "
        + " | ".join(cell.ljust(width) for cell, width in zip(cells, WIDTHS, strict=True)).rstrip()
        + " |"
    )


def _judged(holds: bool) -> str:
    return "holds" if holds else "does not hold"


def _measured(finding: Finding) -> str:
    unit = "" if finding["unit"] == "1" else f" {finding['unit']}"
    return f"{finding['measured']:.5g}{unit}"


def _bound(finding: Finding) -> str:
    low, high = finding["low"], finding["high"]
    if not finding["bounded"]:
        return ""
    if math.isinf(low):
        return f"<= {high:.5g}"
    return f">= {low:.5g}" if math.isinf(high) else f"{low:.5g} to {high:.5g}"
