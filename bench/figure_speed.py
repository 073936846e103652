"""The figures of the paper with fracture, timed: bench/results/figures.csv, and the table of
docs/figures.md.

Run from the repository's root, on a quiet machine, as `make figures-table` does: python
bench/figure_speed.py --mesh BUNNY [SHOT ...]; the table is written if no shot is named.
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import sys
from statistics import median
from typing import Any

from documents import today, write_table

DOCUMENT = "docs/figures.md"
RUNS = 3
#: Figure, shot, and the paper's frames per second [Su09 sec. 5].
SHOTS = (
    (4, "wall", 15.0),
    (4, "wall-ball", 15.0),
    (5, "cylinder", 22.0),
    (6, "bunny", 4.0),
    (7, "refracture", 15.0),
    (8, "rain-25", 3.0),
    (9, "wall-natural", 15.0),
)
#: Of the document's table.
HEAD = (
    "figure",
    "shot",
    "pieces at the end",
    "ms a frame: mean, median, p95, worst",
    "frames a second",
    "the paper's",
    "ratio",
    "with the paper's method",
)
COLUMNS = (
    "date",
    "shot",
    "method",
    "frames",
    "bodies_end",
    "ms_mean",
    "ms_median",
    "ms_p95",
    "ms_max",
    "fps_mean",
    "fps_paper",
    "ratio",
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("shots", nargs="*", metavar="SHOT", help="of figures [all]")
    parser.add_argument("--mesh", help="the Stanford bunny, for figure 6")
    options = parser.parse_args()
    if not options.mesh and (not options.shots or "bunny" in options.shots):
        parser.error("--mesh: must be the Stanford bunny's file, for figure 6")
    rows: list[dict[str, Any]] = []
    for _, shot, paper in SHOTS:
        if options.shots and shot not in options.shots:
            continue
        for method in ("frame-rate", "paper"):
            if (shot, method) == ("rain-25", "paper"):
                continue
            mesh = ["--mesh", options.mesh] if shot == "bunny" else []
            command = [
                sys.executable,
                "-m",
                "frangible",
                "run",
                shot,
                "--method",
                method,
                "--threads",
                "1",
                "--json",
                *mesh,
            ]
            outputs = [
                subprocess.run(command, check=True, capture_output=True, text=True).stdout
                for _ in range(RUNS)
            ]
            runs = [json.loads(output.splitlines()[-1]) for output in outputs]
            times = {
                key: median(run["ms_per_frame"][key] for run in runs)
                for key in ("mean", "median", "p95", "max")
            }
            row = {
                "date": today(),
                "shot": shot,
                "method": method,
                "frames": runs[0]["frames"],
                "bodies_end": runs[0]["bodies"]["end"],
                **{f"ms_{key}": round(value, 2) for key, value in times.items()},
                "fps_mean": round(1e3 / times["mean"], 1),
                "fps_paper": paper,
                "ratio": round(1e3 / times["mean"] / paper, 1),
            }
            print(row, flush=True)
            rows.append(row)
    if options.shots:
        return
    with open("bench/results/figures.csv", "w", newline="") as file:
        file.write(
            f"# command: python bench/figure_speed.py; medians of {RUNS} runs, "
            "one thread; 2-core shared x86-64 server, release build\n"
        )
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    sentence = f"The table is of {today()}, medians of {RUNS} runs."
    write_table(DOCUMENT, [HEAD, *table(rows)], sentence)


def table(rows: list[dict[str, Any]]) -> list[list[str]]:
    """The document's rows, one for each shot."""
    by_method = {(row["shot"], row["method"]): row for row in rows}
    lines = []
    for figure, shot, paper in SHOTS:
        ours, theirs = by_method[shot, "frame-rate"], by_method.get((shot, "paper"))
        times = ", ".join(f"{ours[f'ms_{key}']:.2f}" for key in ("mean", "median", "p95", "max"))
        lines.append(
            [
                str(figure),
                f"`{shot}`",
                str(ours["bodies_end"]),
                times,
                f"{ours['fps_mean']:.0f}",
                f"{paper:.0f}",
                f"{ours['ratio']:.1f}",
                f"{theirs['fps_mean']:.0f}" if theirs else "",
            ]
        )
    return lines


if __name__ == "__main__":
    main()
