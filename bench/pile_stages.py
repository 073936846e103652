"""The piles alone, stage by stage: a table of docs/performance.md.

Run from the repository's root, on a quiet machine, as `make performance` does: python
bench/pile_stages.py [--frames N] [SHOT ...]; the table is written if no shot is named, and rows are
appended to bench/results/stages.csv.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from typing import Any

from documents import today, write_table

DOCUMENT = "docs/performance.md"
RESULTS = "bench/results"
SHOTS = ("pile-spread", "pile-deep", "pile-table", "bricks", "bricks-still")
#: Stages that are told, the longest first.
TOLD = 4
HEAD = (
    "shot",
    "pieces",
    "frames",
    "ms a frame: median, p95, worst",
    "longest stages, median ms",
    "KiB a piece",
    "stands",
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("shots", nargs="*", metavar="SHOT", help="to measure and to print [all]")
    parser.add_argument("--frames", type=int, metavar="N", help="number of steps [each shot's]")
    options = parser.parse_args()
    lines = []
    with tempfile.TemporaryDirectory() as folder:
        for shot in options.shots or SHOTS:
            lines.append(row(_measured(shot, options.frames, folder if options.shots else RESULTS)))
            print(" | ".join(lines[-1]), flush=True)
    if options.shots:
        return
    steps = f", the first {options.frames} frames" if options.frames else ""
    write_table(DOCUMENT, [HEAD, *lines], f"The stages are of {today()}, one thread{steps}.")


def _measured(shot: str, frames: int | None, folder: str) -> dict[str, Any]:
    command = [sys.executable, "-m", "frangible", "bench", shot, "--json", "--out", folder]
    if frames is not None:
        command += ["--frames", str(frames)]
    output = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    summary: dict[str, Any] = json.loads(output.splitlines()[-1])
    return summary


def row(summary: dict[str, Any]) -> list[str]:
    """The document's row of a shot, over all of its frames."""
    frame = summary["ms_per_frame_all"]
    stages = {name: times["median"] for name, times in summary["stages_all_ms"].items()}
    longest = sorted(stages, key=lambda name: -stages[name])[:TOLD]
    return [
        f"`{summary['shot']}`",
        str(summary["pieces"]),
        str(summary["frames"]),
        ", ".join(f"{frame[key]:.3g}" for key in ("median", "p95", "max")),
        ", ".join(f"{name} {stages[name]:.3g}" for name in longest),
        f"{summary['memory_per_piece_KiB']:.3g}",
        f"{100.0 * summary['standing']:.0f} %",
    ]


if __name__ == "__main__":
    main()
