"""Quality and cost of this engine and of others, from 1 to 64 substeps of a frame:
bench/results/curve.csv and docs/images/curve.svg.

Each engine steps the same piles with one number of substeps after the other, by turns. Needs the
extra `plot` and all that `frangible bench --peers` needs. Run from the repository's root, on a
quiet machine: taskset -c 1 python bench/curve.py; with --draw it only draws the table anew.
"""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from frangible.bench.pile_file import Pile

TABLE = os.path.join("bench", "results", "curve.csv")
FIGURE = os.path.join("docs", "images", "curve.svg")
SUBSTEPS = (1, 2, 4, 8, 16, 32, 64)
#: Of up to so many substeps the fastest of three runs counts, of more there is one.
OFTEN, RUNS = 8, 3
#: Ours, by the least number of substeps.
QUALITIES = {2: "draft", 4: "game", 8: "default", 16: "film"}
#: Those that take shorter steps, too.
SHORTENED = ("draft", "film")
#: Other engines whose steps take substeps with the same contacts, so many as they come. Of the
#: rest each substep is a step.
SUBSTEPS_OF_A_STEP = {"peer-box3d": 4, "peer-rapier": 4}
#: Overlaps of all frames are those of every fifth: to find them takes longer than most steps.
EVERY = 5
#: Of `pile-deep`: from piece to piece before they fall [m], and in a row.
PITCH, ROW = 0.205, 24
COLUMNS = (
    "date", "shot", "engine", "substeps", "steps", "frames", "cpu_median_ms", "cpu_p95_ms",
    "cpu_total_ms", "penetration_p50_mm", "penetration_p99_mm", "penetration_all_p99_mm",
    "standing",
)  # fmt: skip
#: Name of the engine, steps of a frame, and processor time of a frame [ms].
Run = tuple[str, int, dict[str, float]]


def pit() -> dict[str, Any]:
    """The middle of `pile-deep`: 8 by 8 pieces in 16 layers, with the walls of the pit closer."""
    scene = shot_scene("pile-deep")
    half, moved = 4 * PITCH, (ROW / 2 - 4) * PITCH
    bodies = []
    for body in scene["bodies"]:
        x, y, z = body["position"]
        if body["name"] == "pit":
            body["position"] = [x - moved * np.sign(x), y, z - moved * np.sign(z)]
        if body["name"] != "piece" or max(abs(x), abs(z)) < half:
            bodies.append(body)
    return scene | {"bodies": bodies}


def shot_scene(shot: str) -> dict[str, Any]:
    """The scene of one of the project's shots."""
    import frangible

    scene: dict[str, Any] = json.loads(frangible.shot_scene(shot))
    return scene


#: A scene, and frames.
SHOTS: dict[str, tuple[Callable[[], dict[str, Any]], int]] = {
    "pit": (pit, 110),
    "bricks-still": (lambda: shot_scene("bricks-still"), 150),
}


def step_ours(scene: str, frames: int, steps: int, times: str, states: str) -> None:
    """As the programs of the other engines, in a process of its own."""
    from frangible import World

    world = World.build(Path(scene).read_text(encoding="utf-8"), 1)
    spent = []
    with open(states, "wb") as file:
        for _ in range(frames):
            begin = time.process_time()
            for _ in range(steps):
                world.step()
            spent.append(1e3 * (time.process_time() - begin))
            pose = (world.positions, world.orientations)
            state = (*pose, world.velocities, world.angular_velocities)
            file.write(np.concatenate(state, axis=1).astype("<f4").tobytes())
    np.savetxt(times, spent)


def run_ours(
    scene: dict[str, Any], frames: int, states: str, quality: str, steps: int
) -> dict[str, float]:
    """The times of the frames, each of so many shorter steps."""
    from frangible.bench.summary import spread

    path, times = states + ".json", states + ".times"
    rate = scene["frames_per_second"] * steps
    described = scene | {"frames_per_second": rate, "solver": {"quality": quality}}
    Path(path).write_text(json.dumps(described), encoding="utf-8")
    command = [sys.executable, __file__, path, str(frames), str(steps), times, states]
    subprocess.run(command, check=True)
    return spread(np.loadtxt(times).tolist())


def run_all(
    scene: dict[str, Any], folder: str, frames: int, substeps: int, programs: Sequence[Path]
) -> Iterator[Run]:
    """Each engine with one number of substeps, in one step of a frame and in several; after each
    the folder's file of states is that run's."""
    from frangible.bench import peers

    pile, states = os.path.join(folder, "pile"), os.path.join(folder, "states")
    for least, quality in QUALITIES.items():
        steps = substeps // least
        if substeps == least or (quality in SHORTENED and steps > 1):
            yield peers.OURS, steps, run_ours(scene, frames, states, quality, steps)
    for program in programs:
        own = SUBSTEPS_OF_A_STEP.get(program.name)
        engine, times, _ = peers.run_peer(program, pile, frames, states, (substeps,))
        yield engine, substeps if own is None else 1, times
        if own is not None and substeps > own:
            steps = substeps // own
            engine, times, _ = peers.run_peer(program, pile, frames, states, (own, steps))
            yield engine, steps, times


def measure(shot: str, programs: Sequence[Path]) -> Iterator[dict[str, Any]]:
    """A row for each engine, number of substeps and of steps, as `COLUMNS` names them."""
    from frangible.bench.pile_file import Pile
    from frangible.bench.stage_times import today

    make, frames = SHOTS[shot]
    scene = make()
    pile = Pile.of_scene(shot, scene)
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "pile"), "wb") as file:
            pile.write(file)
        for substeps in SUBSTEPS:
            rows: dict[tuple[str, int], dict[str, Any]] = {}
            for _ in range(RUNS if substeps <= OFTEN else 1):
                for engine, steps, times in run_all(scene, folder, frames, substeps, programs):
                    # A run is the same every time but for how long it takes.
                    key = (engine, steps)
                    if key not in rows:
                        rows[key] = {
                            "date": today(),
                            "shot": shot,
                            "engine": engine,
                            "substeps": substeps,
                            "steps": steps,
                            "frames": frames,
                            **judged(pile, os.path.join(folder, "states")),
                        }
                    if times["mean"] * frames < rows[key].get("cpu_total_ms", np.inf):
                        rows[key] |= {
                            "cpu_median_ms": round(times["median"], 2),
                            "cpu_p95_ms": round(times["p95"], 2),
                            "cpu_total_ms": round(times["mean"] * frames),
                        }
            yield from rows.values()


def judged(pile: Pile, path: str) -> dict[str, float]:
    """The columns about quality, from a file of states."""
    from frangible.bench.peers import judge
    from frangible.bench.pile_file import load_states

    states = load_states(path, pile)
    quality = judge(pile, states)
    depths = np.concatenate([pile.penetrations(state) for state in states[EVERY - 1 :: EVERY]])
    median, p99, _ = quality.penetration
    return {
        "penetration_p50_mm": round(1e3 * median, 3),
        "penetration_p99_mm": round(1e3 * p99, 3),
        "penetration_all_p99_mm": round(1e3 * float(np.percentile(depths, 99)), 3),
        "standing": round(quality.stands.share, 4),
    }


def better_in_both(rows: Sequence[dict[str, str]], shot: str, depth: str) -> Iterator[str]:
    """A line for each of our points that is on our front, with the others' points that take less
    time in all and overlap less."""

    def is_better(row: dict[str, str], than: dict[str, str]) -> bool:
        return all(float(row[key]) < float(than[key]) for key in ("cpu_total_ms", depth))

    def effort(row: dict[str, str]) -> str:
        return f"{row['substeps']} in {row['steps']}"

    points = [row for row in rows if row["shot"] == shot]
    ours = [row for row in points if row["engine"] == "frangible"]
    for point in ours:
        if not any(is_better(row, point) for row in ours):
            better: dict[str, list[str]] = {}
            for row in points:
                if row["engine"] != point["engine"] and is_better(row, point):
                    better.setdefault(row["engine"], []).append(effort(row))
            others = [f"{engine} ({', '.join(efforts)})" for engine, efforts in better.items()]
            yield f"{shot}, {depth}, {effort(point)}: {'; '.join(others) or 'none'}"


#: Shot, column, its label and its scale.
PANELS = (
    ("pit", "penetration_all_p99_mm", "overlap in all frames, p99 [mm]", "log"),
    ("pit", "penetration_p99_mm", "overlap at the end, p99 [mm]", "log"),
    ("bricks-still", "penetration_all_p99_mm", "overlap in all frames, p99 [mm]", "log"),
    ("bricks-still", "standing", "share of the bricks that stand after 5 s", "linear"),
)


def draw(rows: Sequence[dict[str, str]], path: str) -> None:
    """A panel for each of `PANELS`, with a colour for each engine."""
    from frangible.render.plot import COLOURS
    from matplotlib import rc_context
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

    names = dict.fromkeys(["frangible", *(row["engine"] for row in rows)])
    colours = dict(zip(names, ("#000000", *COLOURS), strict=False))
    # Text stays text, and equal tables give equal files.
    with rc_context({"svg.hashsalt": "frangible", "svg.fonttype": "none"}):
        figure = Figure(figsize=(11.0, 9.0), layout="constrained")
        axes = figure.subplots(2, 2).flat
        for axis, (shot, column, label, scale) in zip(axes, PANELS, strict=True):
            for engine, colour in colours.items():
                of_engine = [r for r in rows if (r["shot"], r["engine"]) == (shot, engine)]
                draw_engine(axis, of_engine, column, colour)
            axis.set(xscale="log", yscale=scale, ylabel=label)
            axis.set_xlabel("processor time of a frame, mean [ms]")
            for side in (axis.xaxis, *([axis.yaxis] if scale == "log" else [])):
                side.set_major_locator(LogLocator(subs=(1, 2, 5)))
                side.set_major_formatter(StrMethodFormatter("{x:g}"))
                side.set_minor_locator(NullLocator())
            axis.set_title(shot, loc="left")
            axis.grid(color="0.92")
            axis.spines[["top", "right"]].set_visible(False)
        legend = axis.get_legend_handles_labels()
        figure.legend(*legend, loc="outside lower center", ncols=4, frameon=False)
        figure.savefig(path, metadata={"Date": None})


def draw_engine(axis: Any, rows: Sequence[dict[str, str]], column: str, colour: str) -> None:
    """A line through an engine's points, each with its substeps: dashed in shorter steps, unless
    these are its substeps anyway."""

    def is_whole(row: dict[str, str]) -> bool:
        """One step of a frame, and of ours `film` beyond 16 substeps."""
        return int(row["steps"]) <= max(1, int(row["substeps"]) // 16)

    whole = [row for row in rows if is_whole(row)]
    short = [row for row in rows if not is_whole(row)]
    engine = rows[0]["engine"]
    lines = [(engine, whole, "-"), (f"{engine}, shorter steps", short, "--")]
    for name, points, style in lines if len(whole) > 1 else [(engine, rows, "-")]:
        cost = [float(row["cpu_total_ms"]) / int(row["frames"]) for row in points]
        values = [float(row[column]) for row in points]
        width = 2.2 if engine == "frangible" else 1.1
        look = {"color": colour, "linewidth": width, "markersize": 3.5}
        axis.plot(cost, values, style, marker="o", label=name, **look)
        for row, *place in zip(points, cost, values, strict=True):
            shift = {"xytext": (3, 3), "textcoords": "offset points"}
            axis.annotate(row["substeps"], place, fontsize=7, color=colour, **shift)


def write_table() -> None:
    """Run everything, row by row into the table."""
    from frangible.bench import peers

    programs = [program for package in peers.packages() for program in peers.build(package)]
    with open(TABLE, "w", newline="", encoding="utf-8") as file:
        file.write("# command: taskset -c 1 python bench/curve.py; processor time\n")
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        for shot in SHOTS:
            for row in measure(shot, programs):
                print(row, flush=True)
                table.writerow(row)
                file.flush()


def main() -> None:
    if len(sys.argv) == 6:
        scene, frames, steps, times, states = sys.argv[1:]
        step_ours(scene, int(frames), int(steps), times, states)
        return
    if "--draw" not in sys.argv:
        write_table()
    with open(TABLE, newline="", encoding="utf-8") as file:
        next(file)
        rows = list(csv.DictReader(file))
    for shot in SHOTS:
        for depth in ("penetration_all_p99_mm", "penetration_p99_mm"):
            print(*better_in_both(rows, shot, depth), sep="\n")
    draw(rows, FIGURE)


if __name__ == "__main__":
    main()
