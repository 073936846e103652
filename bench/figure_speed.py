"""The figures of the paper with fracture, timed: bench/results/figures.csv.

Run from the repository's root, on a quiet machine: python bench/figure_speed.py [--mesh BUNNY]
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import sys
from datetime import UTC, datetime
from statistics import median

RUNS = 3
#: Shot, and the paper's frames per second [Su09 sec. 5].
SHOTS = (
    ("wall", 15.0),
    ("wall-ball", 15.0),
    ("cylinder", 22.0),
    ("bunny", 4.0),
    ("refracture", 15.0),
    ("wall-natural", 15.0),
    ("rain-25", 3.0),
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
    parser.add_argument("--mesh", help="the Stanford bunny, for figure 6")
    options = parser.parse_args()
    rows = []
    for shot, paper in SHOTS:
        if shot == "bunny" and not options.mesh:
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
                "date": datetime.now(UTC).date().isoformat(),
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
    with open("bench/results/figures.csv", "w", newline="") as file:
        file.write(
            f"# command: python bench/figure_speed.py; medians of {RUNS} runs, "
            "one thread; 2-core shared x86-64 server, release build\n"
        )
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
