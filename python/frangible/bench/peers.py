"""The same piles in other engines: ``frangible bench --peers``.

Each engine has a program of its own in a folder under `PROGRAMS`, or one for each of its solvers,
which reads a pile from a file (`pile_file`), steps it with the settings that the engine comes with,
and writes how much processor time each frame took and where everything was. All that is said of an
engine is measured here, from what its program wrote, by the same code for all.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from .. import _frangible
from ..recording import Float64
from .pile_file import Pile, load_states
from .run_process import LAST_FRAMES, BenchError, Request, run_apart
from .stage_times import append_rows, today
from .standing import Standing, standing
from .summary import spread

#: Beside the sources, from the root of the repository.
PROGRAMS = Path("bench") / "peers"

#: Piles that other engines run by default.
PILES = ("pile-spread", "pile-deep", "pile-table", "bricks", "bricks-still")

OURS = "frangible"

COLUMNS = (
    "date", "shot", "engine", "frames", "runs", "cpu_median_ms", "cpu_p95_ms", "cpu_max_ms",
    "time_ratio", "penetration_p50_mm", "penetration_p99_mm", "penetration_max_mm", "energy_gain",
    "pieces_lost", "memory_per_piece_KiB", "standing", "median_height_m",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Quality:
    """Result of a run, apart from its time."""

    #: Median, 99th percentile and maximum of how deep overlapping pairs are at the end [m].
    penetration: tuple[float, float, float]
    #: Largest rise of the energy of all pieces in a frame, in units of their energy at the start,
    #: relative to the ground.
    energy_gain: float
    #: Wholly below the ground, far away or nowhere at the end.
    lost: int
    #: Of all pieces.
    stands: Standing


@dataclass(frozen=True, slots=True)
class Result:
    """An engine's runs of a pile."""

    engine: str
    #: Medians over the runs of the processor time that the last frames took [ms].
    times: dict[str, float]
    #: By how much memory grew at most, by piece, in the last of them [KiB].
    memory: float
    quality: Quality


def packages(folder: Path = PROGRAMS) -> list[Path]:
    """The folders of the engines' programs; `BenchError` if there are none here."""
    found = sorted(path.parent.parent for path in folder.glob("*/src/main.rs"))
    if not found:
        raise BenchError(f"--peers: {folder}, must be here: run it from the root of the repository")
    return found


def build(package: Path) -> list[Path]:
    """The paths of a package's programs, compiled for this machine; none if that fails, after
    saying why on stderr."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", "target")).absolute() / "peers"
    command = [
        "cargo",
        "build",
        "--release",
        "--locked",
        "--quiet",
        "--manifest-path",
        str(package / "Cargo.toml"),
        "--target-dir",
        str(target),
    ]
    try:
        done = subprocess.run(
            command,
            env=os.environ | _compiler_settings(),
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    except FileNotFoundError:
        print(
            f"{package.name}: left out, because there is no Cargo to build it",
            file=sys.stderr,
            flush=True,
        )
        return []
    if done.returncode != 0:
        errors = [line for line in done.stderr.splitlines() if line.startswith("error")]
        print(
            f"{done.stderr}{package.name}: left out, because Cargo cannot build it: "
            f"{''.join(errors[:1])}",
            file=sys.stderr,
            flush=True,
        )
        return []
    names = [f"peer-{package.name}", *sorted(path.stem for path in package.glob("src/bin/*.rs"))]
    return [target / "release" / name for name in names]


def _compiler_settings() -> dict[str, str]:
    """All compilers know this very processor, PhysX takes what there is for C++, and what makes
    Rust's names for C finds libclang and headers."""
    settings = {
        "RUSTFLAGS": os.environ.get("RUSTFLAGS", "") + " -C target-cpu=native",
        "CXX": os.environ.get("CXX", "c++"),
    }
    for variable in ("CFLAGS", "CXXFLAGS"):
        settings[variable] = os.environ.get(variable, "") + " -march=native"
    libclang = importlib.util.find_spec("clang")
    if (
        "LIBCLANG_PATH" not in os.environ
        and libclang is not None
        and libclang.submodule_search_locations
    ):
        settings["LIBCLANG_PATH"] = os.path.join(libclang.submodule_search_locations[0], "native")
        headers = subprocess.run(
            ["cc", "-print-file-name=include"], stdout=subprocess.PIPE, text=True, check=False
        ).stdout.strip()
        settings["BINDGEN_EXTRA_CLANG_ARGS"] = (
            os.environ.get("BINDGEN_EXTRA_CLANG_ARGS", "") + f" -I{headers}"
        )
    return settings


def compare(
    shots: Sequence[str],
    *,
    frames: int | None,
    runs: int,
    folder: str,
    on_done: Callable[[list[dict[str, Any]]], None],
) -> None:
    """Run piles in this engine and in all others that can be built, by turns, and append the
    results to a table in a folder."""
    piles = {shot: Pile.of_shot(shot) for shot in shots}
    built = [program for package in packages() for program in build(package)]
    os.makedirs(folder, exist_ok=True)
    _stay_on_one_core()
    for shot, pile in piles.items():
        count = _frangible.shot_frames(shot) if frames is None else frames
        rows = result_rows(shot, count, runs, _run_by_turns(shot, pile, built, count, runs))
        append_rows(os.path.join(folder, "peers.csv"), COLUMNS, rows)
        on_done(rows)


def _run_by_turns(
    shot: str, pile: Pile, built: Sequence[Path], frames: int, runs: int
) -> list[Result]:
    times: dict[str, list[dict[str, float]]] = {}
    memories: dict[str, float] = {}
    qualities: dict[str, Quality] = {}
    with tempfile.TemporaryDirectory() as folder:
        path, states = os.path.join(folder, "pile"), os.path.join(folder, "states")
        with open(path, "wb") as file:
            pile.write(file)
        for _ in range(runs):
            for program in (None, *built):
                name, spent, memory = (
                    _run_ours(shot, frames, states)
                    if program is None
                    else run_peer(program, path, frames, states)
                )
                times.setdefault(name, []).append(spent)
                memories[name] = memory / float(pile.moves.sum())
                # A run is the same every time but for how long it takes.
                if name not in qualities:
                    qualities[name] = judge(pile, load_states(states, pile))
    return [
        Result(
            name,
            {key: median(run[key] for run in spent) for key in ("median", "p95", "max")},
            memories[name],
            qualities[name],
        )
        for name, spent in times.items()
    ]


def _run_ours(shot: str, frames: int, states: str) -> tuple[str, dict[str, float], float]:
    summary = run_apart(Request(shot, frames, 1, states))
    return OURS, summary["cpu_ms_per_frame"], summary["memory_per_piece_KiB"] * summary["pieces"]


def run_peer(
    program: Path, pile: str, frames: int, states: str, effort: Sequence[int] = ()
) -> tuple[str, dict[str, float], float]:
    """The name that an engine's program prints, the times of its run, and by how much its memory
    grew [KiB], as its last two lines say; what else it says goes to stderr. The effort is the
    number of substeps of a step, and that of steps of a frame: the engine's own and one unless it
    is given."""
    times = states + ".times"
    print(f"{program.name}: {frames} frames", file=sys.stderr, flush=True)
    done = subprocess.run(
        [program, pile, str(frames), times, states, *map(str, effort)],
        stdout=subprocess.PIPE,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise BenchError(f"{program.name}: ended with status {done.returncode}")
    *complaints, name, memory = done.stdout.splitlines()
    for line in complaints:
        print(f"{name}: {line}", file=sys.stderr, flush=True)
    return name, spread(np.loadtxt(times, ndmin=1)[-LAST_FRAMES:].tolist()), float(memory)


def judge(pile: Pile, states: Float64) -> Quality:
    """How good a run is, from the states (f, n, `STATE`) that it went through."""
    energies = pile.energies(np.concatenate([pile.start[None], states]))
    ground = float(np.sum(pile.masses[pile.moves])) * abs(pile.scene["gravity"][1]) * pile.ground
    depths = pile.penetrations(states[-1])
    percentiles = (
        tuple(np.percentile(depths, [50, 99, 100]).tolist()) if len(depths) else (0.0, 0.0, 0.0)
    )
    gain = max(float(np.diff(energies).max()), 0.0) / (float(energies[0]) - ground)
    start, end = (state[pile.moves, :3] for state in (pile.start, states[-1]))
    stands = standing(start, end, pile.widths[pile.moves])
    return Quality(percentiles, gain, int(pile.lost(states[-1]).sum()), stands)


def result_rows(
    shot: str, frames: int, runs: int, results: Sequence[Result]
) -> list[dict[str, Any]]:
    """A row for each engine, ours first, as `COLUMNS` names them; a ratio is a time in units of
    ours."""
    ours = results[0].times["median"]
    return [
        {
            "date": today(),
            "shot": shot,
            "engine": result.engine,
            "frames": frames,
            "runs": runs,
            **{f"cpu_{key}_ms": round(value, 2) for key, value in result.times.items()},
            "time_ratio": round(result.times["median"] / ours, 2),
            **{
                f"penetration_{key}_mm": round(1e3 * depth, 3)
                for key, depth in zip(
                    ("p50", "p99", "max"), result.quality.penetration, strict=True
                )
            },
            "energy_gain": f"{result.quality.energy_gain:.2g}",
            "pieces_lost": result.quality.lost,
            "memory_per_piece_KiB": round(result.memory, 2),
            "standing": round(result.quality.stands.share, 4),
            "median_height_m": round(result.quality.stands.median_height, 4),
        }
        for result in results
    ]


def describe_peers(rows: Sequence[dict[str, Any]]) -> str:
    """The table for people."""
    shot, frames = rows[0]["shot"], rows[0]["frames"]
    heads = (
        "engine",
        "median ms",
        "p95",
        "max",
        "of ours",
        "overlap mm p50",
        "p99",
        "max",
        "energy gained",
        "lost",
        "KiB a piece",
        "standing",
        "median height m",
    )
    keys = ("engine", *COLUMNS[5:])
    cells = [heads, *(tuple(str(row[key]) for key in keys) for row in rows)]
    widths = [max(len(line[column]) for line in cells) for column in range(len(heads))]
    lines = [
        "  ".join(
            cell.ljust(width) if at == 0 else cell.rjust(width)
            for at, (cell, width) in enumerate(zip(line, widths, strict=True))
        )
        for line in cells
    ]
    return "\n".join(
        [
            f"{shot}: the last {min(frames, LAST_FRAMES)} of {frames} frames, {rows[0]['runs']} "
            "runs by turns on one core, processor time",
            *lines,
        ]
    )


def _stay_on_one_core() -> None:
    """This process and those that it starts; where the system can."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
