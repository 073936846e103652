"""Quality and cost of this engine and of others, from 1 to 64 substeps: bench/results/curve.csv.

Each engine steps the same piles with one number of substeps after the other, by turns. Needs the
extra `plot` and all that `frangible bench --peers` needs. Run from the repository's root, on a
quiet machine: python bench/curve.py; with --draw it only draws the table anew.
"""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

TABLE = os.path.join("bench", "results", "curve.csv")
FIGURE = os.path.join("docs", "images", "curve.svg")
#: Of the other engines.
SUBSTEPS = (1, 2, 4, 8, 16, 32, 64)
#: Our quality, and the steps of a frame: film takes 16 substeps at least in each of them.
OURS = {
    2: ("draft", 1),
    4: ("game", 1),
    8: ("default", 1),
    16: ("film", 1),
    32: ("film", 2),
    64: ("film", 4),
}
COLUMNS = (
    "date", "shot", "engine", "substeps", "frames", "cpu_median_ms", "cpu_p95_ms", "cpu_total_ms",
    "penetration_p50_mm", "penetration_p99_mm", "penetration_all_p99_mm", "standing",
)  # fmt: skip
#: Overlaps of all frames are those of every fifth: to find them takes longer than most steps.
EVERY = 5
#: Of `pile-deep`: from piece to piece before they fall [m], and in a row.
PITCH, ROW = 0.205, 24


def pit() -> dict[str, Any]:
    """The middle of `pile-deep`: 8 by 8 pieces in 16 layers, with the walls of the pit closer."""
    import frangible

    scene = json.loads(frangible.shot_scene("pile-deep"))
    half, moved = 4 * PITCH, (ROW / 2 - 4) * PITCH
    bodies = []
    for body in scene["bodies"]:
        x, y, z = body["position"]
        if body["name"] == "pit":
            body["position"] = [x - moved * np.sign(x), y, z - moved * np.sign(z)]
        if body["name"] != "piece" or max(abs(x), abs(z)) < half:
            bodies.append(body)
    return scene | {"bodies": bodies}


def wall() -> dict[str, Any]:
    """A wall of 1,000 loose bricks that nobody touches."""
    import frangible

    scene: dict[str, Any] = json.loads(frangible.shot_scene("bricks-still"))
    return scene


#: A scene, and frames.
SHOTS: dict[str, tuple[Callable[[], dict[str, Any]], int]] = {
    "pit": (pit, 110),
    "bricks-still": (wall, 150),
}


def step_ours(scene: str, frames: int, steps: int, times: str, states: str) -> None:
    """In a process of its own: as the other engines' programs, with so many steps of a frame."""
    from frangible import World

    world = World.build(Path(scene).read_text(encoding="utf-8"), 1)
    spent = []
    with open(states, "wb") as file:
        for _ in range(frames):
            begin = time.process_time()
            for _ in range(steps):
                world.step()
            spent.append(1e3 * (time.process_time() - begin))
            state = (world.positions, world.orientations, world.velocities, world.angular_velocities)
            file.write(np.concatenate(state, axis=1).astype("<f4").tobytes())
    np.savetxt(times, spent)


def run_ours(scene: dict[str, Any], frames: int, states: str, substeps: int) -> dict[str, float]:
    """The times of a run with so many substeps of a frame at least."""
    from frangible.summary import spread

    quality, steps = OURS[substeps]
    path, times = states + ".json", states + ".times"
    rate = scene["frames_per_second"] * steps
    described = scene | {"frames_per_second": rate, "solver": {"quality": quality}}
    Path(path).write_text(json.dumps(described), encoding="utf-8")
    command = [sys.executable, __file__, path, str(frames), str(steps), times, states]
    subprocess.run(command, check=True)
    return spread(np.loadtxt(times).tolist())


def measure(shot: str, programs: list[Path]) -> Iterator[dict[str, Any]]:
    """A row for each run of a shot, as `COLUMNS` names them."""
    from frangible import peers
    from frangible.bench import today
    from frangible.pile_file import Pile, load_states

    make, frames = SHOTS[shot]
    scene = make()
    pile = Pile.of_scene(shot, scene)
    with tempfile.TemporaryDirectory() as folder:
        path, states = os.path.join(folder, "pile"), os.path.join(folder, "states")
        with open(path, "wb") as file:
            pile.write(file)
        for substeps in SUBSTEPS:
            for program in (None, *programs):
                if program is None and substeps not in OURS:
                    continue
                if program is None:
                    engine, times = peers.OURS, run_ours(scene, frames, states, substeps)
                else:
                    engine, times, _ = peers.run_peer(
                        program, path, frames, states, substeps=substeps
                    )
                passed = load_states(states, pile)
                quality = peers.judge(pile, passed)
                depths = np.concatenate([pile.penetrations(state) for state in passed[EVERY - 1 :: EVERY]])
                yield {
                    "date": today(),
                    "shot": shot,
                    "engine": engine,
                    "substeps": substeps,
                    "frames": frames,
                    "cpu_median_ms": round(times["median"], 2),
                    "cpu_p95_ms": round(times["p95"], 2),
                    "cpu_total_ms": round(times["mean"] * frames),
                    "penetration_p50_mm": round(1e3 * quality.penetration[0], 3),
                    "penetration_p99_mm": round(1e3 * quality.penetration[1], 3),
                    "penetration_all_p99_mm": round(1e3 * float(np.percentile(depths, 99)), 3),
                    "standing": round(quality.stands.share, 4),
                }


def better_in_both(rows: list[dict[str, Any]], depth: str) -> Iterator[str]:
    """A line for each of our points: others that take less time in all and overlap less."""
    for ours in (row for row in rows if row["engine"] == "frangible"):
        better = [
            f"{row['engine']} with {row['substeps']}"
            for row in rows
            if row["shot"] == ours["shot"]
            and float(row["cpu_total_ms"]) < float(ours["cpu_total_ms"])
            and float(row[depth]) < float(ours[depth])
        ]
        found = ", ".join(row for row in better if not row.startswith("frangible")) or "none"
        yield f"{ours['shot']}, {depth}, ours with {ours['substeps']}: {found}"


#: Shot, column, what it says, and its scale.
PANELS = (
    ("pit", "penetration_all_p99_mm", "overlap of all frames, p99 [mm]", "log"),
    ("pit", "penetration_p99_mm", "overlap at the end, p99 [mm]", "log"),
    ("bricks-still", "penetration_all_p99_mm", "overlap of all frames, p99 [mm]", "log"),
    ("bricks-still", "standing", "bricks that stand after 5 s", "linear"),
)


def draw(rows: list[dict[str, Any]], path: str) -> None:
    """Cost and quality of each run: a line for an engine, a point for a number of substeps."""
    from frangible.plot import COLOURS
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    engines = list(dict.fromkeys(row["engine"] for row in rows))
    # Text stays text, and equal tables give equal files.
    with rc_context({"svg.hashsalt": "frangible", "svg.fonttype": "none"}):
        figure = Figure(figsize=(11.0, 8.5), layout="constrained")
        for axis, (shot, column, label, scale) in zip(figure.subplots(2, 2).flat, PANELS, strict=True):
            for engine, colour in zip(engines, ("#000000", *COLOURS), strict=False):
                points = [row for row in rows if (row["shot"], row["engine"]) == (shot, engine)]
                cost = [float(row["cpu_total_ms"]) / int(row["frames"]) for row in points]
                values = [float(row[column]) for row in points]
                width = 2.2 if engine == "frangible" else 1.2
                axis.plot(cost, values, marker="o", markersize=4, color=colour, linewidth=width, label=engine)
                for row, x, y in zip(points, cost, values, strict=True):
                    axis.annotate(row["substeps"], (x, y), (3, 3), textcoords="offset points", fontsize=7, color=colour)
            axis.set(xscale="log", yscale=scale, xlabel="processor time of a frame, mean [ms]", ylabel=label)
            axis.set_title(shot, loc="left")
            axis.grid(color="0.92")
            axis.spines[["top", "right"]].set_visible(False)
        figure.legend(*axis.get_legend_handles_labels(), loc="outside lower center", ncols=6, frameon=False)
        figure.savefig(path, metadata={"Date": None})


def main() -> None:
    if len(sys.argv) == 6:
        scene, frames, steps, times, states = sys.argv[1:]
        step_ours(scene, int(frames), int(steps), times, states)
        return
    if "--draw" not in sys.argv:
        from frangible import peers

        programs = [program for package in peers.packages() for program in peers.build(package)]
        with open(TABLE, "w", newline="", encoding="utf-8") as file:
            file.write("# command: python bench/curve.py; one run each, one core, one thread, processor time\n")
            table = csv.DictWriter(file, COLUMNS)
            table.writeheader()
            for shot in SHOTS:
                for row in measure(shot, programs):
                    print(row, flush=True)
                    table.writerow(row)
                    file.flush()
    with open(TABLE, newline="", encoding="utf-8") as file:
        next(file)
        rows = list(csv.DictReader(file))
    for depth in ("penetration_all_p99_mm", "penetration_p99_mm"):
        print(*better_in_both(rows, depth), sep="\n")
    draw(rows, FIGURE)


if __name__ == "__main__":
    main()
