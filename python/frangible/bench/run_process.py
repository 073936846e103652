"""Runs a shot in a process of its own, so that its memory is the shot's alone.

``python -m frangible.bench.run_process`` reads a `Request` as JSON from stdin, and writes the
summary as JSON to stdout and the progress to stderr.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from .._frangible import World, shot_scene
from ..progress import report_progress
from ..recording import Float64, step_frames
from ..report import StepReport
from .standing import standing
from .summary import RunFigures, Summary, peak_memory, spread

#: A benchmark is about the last so many frames, when most has happened.
LAST_FRAMES = 200

#: Numbers of a body's state: position, orientation, velocity, angular velocity.
STATE = 13


class BenchError(ValueError):
    """What was asked of a benchmark cannot be measured: the message says what and why."""


@dataclass(frozen=True, slots=True)
class Request:
    """What to run."""

    shot: str
    frames: int
    #: 0 means one for every processor.
    threads: int
    #: File for the state after every frame, if it is wanted: float32 (frames, bodies, `STATE`).
    states: str | None = None


def run_apart(request: Request) -> Summary:
    """The summary of a run in a process of its own; `BenchError` if that fails."""
    command = [sys.executable, "-m", "frangible.bench.run_process"]
    done = subprocess.run(
        command, input=json.dumps(asdict(request)), stdout=subprocess.PIPE, text=True, check=False
    )
    if done.returncode != 0:
        raise BenchError(f"{request.shot}: its process ended with status {done.returncode}")
    summary: Summary = json.loads(done.stdout)
    return summary


def run_here(request: Request) -> Summary:
    """The summary of `frangible run` for a run, with times of the last frames and of all,
    also by stage, and memory by piece.

    ``cpu_ms_per_frame`` is processor time of the last frames, of all threads, which other work on
    the machine hardly changes. ``penetration_m`` is of the last state: to look for it between the
    steps would disturb what is timed.
    """
    scene = shot_scene(request.shot)
    # As the other engines' programs count it: from before the world is built.
    memory = peak_memory()
    world = World.build(scene, request.threads)
    start_bodies, start_mass, start_energy = len(world.ids), moving_mass(world), world.energy
    ids = world.ids
    start, widths = world.positions[np.isfinite(world.masses)], _widths(world)
    pieces = ids[np.isfinite(world.masses)].tolist()
    states = None if request.states is None else open(request.states, "wb")
    reports: list[StepReport] = []
    cpu_ms: list[float] = []
    step_ms: list[float] = []
    begin = 0.0

    def keep(report: StepReport, taken_ms: float) -> None:
        nonlocal begin
        step_ms.append(taken_ms)
        cpu_ms.append(1e3 * (time.process_time() - begin))
        reports.append(report)
        if states is not None:
            states.write(_state(world, ids.tolist()).astype("<f4").tobytes())
        begin = time.process_time()

    try:
        with report_progress(request.frames) as progress:
            begin = time.process_time()
            step_frames(world, request.frames, on_step=keep, progress=progress)
    finally:
        if states is not None:
            states.close()
    figures = RunFigures()
    for report, taken_ms in zip(reports, step_ms, strict=True):
        figures.add(report, taken_ms)
    figures.depths.add(world.penetrations())
    summary = figures.summary(
        shot=request.shot,
        method=world.method,
        dt=world.dt,
        state_hash=world.state_hash(),
        bodies=(start_bodies, len(world.ids)),
        mass=(start_mass, moving_mass(world)),
        energy=start_energy,
    )
    count = int(np.isfinite(world.masses).sum())
    stands = standing(start, _state(world, pieces)[:, :3], widths)
    return summary | {
        "threads": request.threads,
        "pieces": count,
        "standing": stands.share,
        "median_height_m": stands.median_height,
        "memory_per_piece_KiB": 1024.0 * (summary["peak_memory_MiB"] - memory) / max(count, 1),
        "ms_per_frame": spread(step_ms[-LAST_FRAMES:]),
        "ms_per_frame_all": spread(step_ms),
        "cpu_ms_per_frame": spread(cpu_ms[-LAST_FRAMES:]),
        "stages_last_ms": _stages(reports[-LAST_FRAMES:]),
        "stages_all_ms": _stages(reports),
    }


def moving_mass(world: World) -> float:
    """Of all dynamic bodies [kg]."""
    masses = world.masses
    return math.fsum(masses[np.isfinite(masses)])


def _widths(world: World) -> Float64:
    """(n,) least widths of the dynamic bodies along the axes of their frames [m]."""
    surfaces = (world.surface(body)[0] for body in world.ids[np.isfinite(world.masses)].tolist())
    return np.array([np.ptp(corners, axis=0).min() for corners in surfaces], dtype=np.float64)


def _state(world: World, ids: list[int]) -> Float64:
    """(n, `STATE`) of the bodies of these ids; not a number for those that are no more."""
    columns = (world.positions, world.orientations, world.velocities, world.angular_velocities)
    living = np.concatenate(columns, axis=1)
    row_of = {body: row for row, body in enumerate(world.ids.tolist())}
    state = np.full((len(ids), STATE), np.nan)
    for place, body in enumerate(ids):
        if body in row_of:
            state[place] = living[row_of[body]]
    return state


def _stages(reports: list[StepReport]) -> dict[str, dict[str, float]]:
    """Spread of the time of each stage; what a frame does twice counts together."""
    frames: list[dict[str, float]] = []
    for report in reports:
        times: dict[str, float] = {}
        for stage, milliseconds in report["stages"]:
            times[stage] = times.get(stage, 0.0) + milliseconds
        frames.append(times)
    names = dict.fromkeys(name for times in frames for name in times)
    return {name: spread([times.get(name, 0.0) for times in frames]) for name in names}


def _main() -> None:
    fields: dict[str, Any] = json.load(sys.stdin)
    json.dump(run_here(Request(**fields)), sys.stdout)


if __name__ == "__main__":
    _main()
