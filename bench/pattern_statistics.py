"""Faces, corners and sizes of the cells of patterns: bench/results/patterns.csv and
docs/images/pattern-sizes.png.

Run from the repository's root: python bench/pattern_statistics.py
"""

from __future__ import annotations

import csv

import numpy as np
from frangible import Pattern
from frangible.render.plot import BLACK, COLOURS
from matplotlib.figure import Figure

SEEDS = range(1, 11)
#: Kind, and cells of each pattern.
KINDS = (("natural", 25), ("natural", 100), ("natural", 1000), ("voronoi", 100), ("voronoi", 1000))
#: Masses, in means, between which the size law is fitted.
FITTED = (0.1, 5.0)


def main() -> None:
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    axis = figure.subplots()
    rows = []
    for kind, cells in KINDS:
        parts = [Pattern.named(kind, cells=cells, seed=seed).shapes() for seed in SEEDS]
        faces, corners, volumes, inner = (
            np.concatenate(column) for column in zip(*parts, strict=True)
        )
        sizes = np.sort(volumes / volumes.mean())
        above = np.arange(len(sizes), 0, -1)
        # Of what is found between the bounds, the steepness of the number of larger cells.
        masses = np.geomspace(FITTED[0], min(FITTED[1], sizes[-10]), 30)
        larger = len(sizes) - np.searchsorted(sizes, masses)
        slope = -np.polyfit(np.log10(masses), np.log10(larger), 1)[0]
        rows.append(
            {
                "pattern": kind,
                "cells": cells,
                "seeds": len(SEEDS),
                "mean_faces": round(float(faces.mean()), 3),
                "mean_corners": round(float(corners.mean()), 3),
                "inner_cells": int(inner.sum()),
                "mean_faces_inner": round(float(faces[inner].mean()), 3) if inner.any() else "",
                "mean_corners_inner": round(float(corners[inner].mean()), 3) if inner.any() else "",
                "deviation_log10_volume": round(float(np.log10(volumes).std()), 3),
                "slope_of_size_law": round(float(slope), 3),
            }
        )
        if cells == 1000:
            axis.loglog(
                sizes,
                above,
                label=f"{kind}, {len(SEEDS)} x {cells} cells",
                color=COLOURS[len(axis.lines)],
            )
    m = np.geomspace(*FITTED, 2)
    axis.loglog(m, 3000 * m ** (-2.5 / 3), "--", color=BLACK, label="rubble: D = 2.5 [Tur86]")
    axis.set_xlabel("mass over the mean mass")
    axis.set_ylabel("number of larger cells")
    axis.set_xlim(1e-4, 30)
    axis.set_ylim(1, 2e4)
    axis.legend()
    axis.grid(color="0.92")
    figure.savefig("docs/images/pattern-sizes.png", dpi=80)

    with open("bench/results/patterns.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
