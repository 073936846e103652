"""How the cost of a piece grows with their number, in heaps of one density:
bench/results/scaling.csv.

Each heap is that of `pile-spread`, its pieces repeated over a wider square. Run from the
repository's root, on a quiet machine: python bench/scaling.py
"""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import tempfile
import time
from datetime import UTC, datetime

import numpy as np

SIZES = (1_000, 10_000, 100_000)
LAYERS = 2
#: From piece to piece before they fall [m]: that of the shot.
PITCH = 0.205
#: They have fallen after 30.
FRAMES, FALLING = 60, 30
COLUMNS = ("date", "pieces", "ms_median", "ms_p95", "us_per_piece", "peak_KiB_per_piece", "growth")


def scene(pieces: int) -> str:
    """The shot's scene with another number of pieces."""
    import frangible

    heap = json.loads(frangible.shot_scene("pile-spread"))
    ground, *kinds = heap["bodies"]
    across = round((pieces / LAYERS) ** 0.5)
    random = np.random.default_rng(1)
    turns = random.normal(size=(across * across * LAYERS, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    bodies = [ground]
    for number, turn in enumerate(turns):
        layer, i, k = number // across**2, number % across, number // across % across
        place = [(i - across / 2) * PITCH, 0.1 + (layer + 0.1) * PITCH, (k - across / 2) * PITCH]
        bodies.append(
            kinds[number % len(kinds)] | {"position": place, "orientation": turn.tolist()}
        )
    return json.dumps(heap | {"bodies": bodies})


def resident(key: str) -> float:
    """``VmRSS``, what this process holds of memory, or ``VmHWM``, the most that it has held [KiB];
    Linux."""
    with open("/proc/self/status", encoding="ascii") as file:
        return next(float(line.split()[1]) for line in file if line.startswith(key))


def measure(path: str) -> dict[str, float]:
    """Processor time of the frames after the fall [ms], and memory while stepping [KiB]."""
    from frangible import World

    before = resident("VmRSS")
    with open(path, encoding="utf-8") as file:
        world = World.build(file.read(), 1)
    # What was needed to read and build it is not of the pieces: the peak begins anew.
    with open("/proc/self/clear_refs", "w", encoding="ascii") as file:
        file.write("5")
    times = []
    for frame in range(FRAMES):
        begin = time.process_time()
        world.step()
        if frame >= FALLING:
            times.append(1e3 * (time.process_time() - begin))
    count = len(world.ids) - 1
    return {
        "pieces": count,
        "ms_median": float(np.median(times)),
        "ms_p95": float(np.percentile(times, 95)),
        "us_per_piece": 1e3 * float(np.median(times)) / count,
        "peak_KiB_per_piece": (resident("VmHWM") - before) / count,
    }


def main() -> None:
    if len(sys.argv) > 1:
        print(json.dumps(measure(sys.argv[1])))
        return
    rows: list[dict[str, object]] = []
    for size in SIZES:
        # In a process of its own, because of the memory.
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "scene.json")
            with open(path, "w", encoding="utf-8") as file:
                file.write(scene(size))
            output = subprocess.run(
                [sys.executable, __file__, path], check=True, capture_output=True, text=True
            ).stdout
        row = json.loads(output.splitlines()[-1])
        first = rows[0]["us_per_piece"] if rows else row["us_per_piece"]
        row = {
            "date": datetime.now(UTC).date().isoformat(),
            **row,
            "growth": row["us_per_piece"] / first,
        }
        rows.append(
            {
                key: round(value, 3) if isinstance(value, float) else value
                for key, value in row.items()
            }
        )
        print(rows[-1], flush=True)
    with open("bench/results/scaling.csv", "w", newline="", encoding="utf-8") as file:
        file.write(
            "# command: python bench/scaling.py; processor time of one thread, "
            "frames 31 to 60; growth is of the time per piece, from the smallest heap on\n"
        )
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    main()
