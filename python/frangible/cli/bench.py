"""``frangible bench``: how long a frame takes."""

from __future__ import annotations

import argparse
import json
from typing import Any

from ..bench.stage_times import RESULTS, bench, describe_bench, shots_to_bench
from ..bench.summary import Summary
from .options import MOST_THREADS, count, naturals


def add_bench(commands: Any) -> None:
    """Add the command."""
    bencher = commands.add_parser(
        "bench", help="measure how long the stages of a frame take, and how much memory a piece"
    )
    bencher.set_defaults(command=_bench)
    bencher.add_argument(
        "shot",
        metavar="SHOT",
        nargs="?",
        help="one of those that `frangible shots` lists, or all [the piles, and some small ones]",
    )
    bencher.add_argument("--frames", type=count, metavar="N", help="number of steps [each shot's]")
    bencher.add_argument(
        "--threads",
        type=naturals(MOST_THREADS),
        default=[1],
        metavar="N[,N]",
        help="0 means one for every processor; of several, each in turn [1]",
    )
    bencher.add_argument(
        "--peers",
        action="store_true",
        help="piles in other engines too, on one core; from the root of the repository",
    )
    bencher.add_argument(
        "--runs",
        type=count,
        default=3,
        metavar="N",
        help="of each engine with --peers, by turns [%(default)s]",
    )
    bencher.add_argument(
        "--out",
        default=RESULTS,
        metavar="FOLDER",
        help="where the table goes that results are appended to [%(default)s]",
    )
    bencher.add_argument(
        "--json",
        action="store_true",
        help="one line of JSON on stdout for every shot, instead of its table",
    )


def _bench(options: argparse.Namespace) -> None:
    def say(summary: Summary) -> None:
        print(json.dumps(summary) if options.json else describe_bench(summary), flush=True)

    if options.peers:
        from ..bench.peers import PILES, compare, describe_peers

        piles = PILES if options.shot is None else shots_to_bench(options.shot)

        def show(rows: list[dict[str, Any]]) -> None:
            print(json.dumps(rows) if options.json else describe_peers(rows), flush=True)

        compare(piles, frames=options.frames, runs=options.runs, folder=options.out, on_done=show)
        return
    shots = shots_to_bench(options.shot)
    bench(shots, frames=options.frames, threads=options.threads, folder=options.out, on_done=say)
