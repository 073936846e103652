"""The ``frangible`` command."""

from __future__ import annotations

import argparse
import json
import math
import os
import signal
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from . import _frangible
from .bench import RESULTS, bench, describe_bench, shots_to_bench
from .breaking import DEFAULT_NORMAL, DEFAULT_VOXELS, MOST_VOXELS, break_mesh
from .cache import CacheError
from .output import Output, OutputError, open_output, open_plot
from .pieces import describe_pieces
from .pieces_files import open_pieces_output
from .progress import report_progress
from .recording import Recorder, Recording, step_frames
from .report import StepReport
from .stepping import BenchError, moving_mass
from .summary import Summary, describe, summarise
from .usd_mesh import readable_mesh
from .verification import ClaimError, Verdict, as_json, table_head, table_rows, verify

#: More threads than any machine has processors.
MOST_THREADS = 4096

EXIT_FAILED = 1
#: Bad input, as for `argparse`.
EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 128 + signal.SIGINT
EXIT_TERMINATED = 128 + signal.SIGTERM
EXIT_PIPE_CLOSED = 128 + signal.SIGPIPE


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; answers with its exit status."""
    # A polite kill unwinds like an interrupt, so that temporary files go away.
    def terminate(*_: object) -> NoReturn:
        sys.exit(EXIT_TERMINATED)

    signal.signal(signal.SIGTERM, terminate)
    options = _parser().parse_args(arguments)
    try:
        status: int = options.command(options) or 0
        sys.stdout.flush()
        return status
    except (_frangible.BuildError, BenchError, CacheError, ClaimError, OutputError) as error:
        print(f"frangible: {error}", file=sys.stderr)
        return EXIT_BAD_INPUT
    except BrokenPipeError:
        # Whoever read our output has seen enough; the interpreter must not try to flush the rest.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_PIPE_CLOSED
    except OSError as error:
        # The disk is full, or the folder went away during the run.
        print(f"frangible: {error.filename or 'output'}: {error.strerror or error}", file=sys.stderr)
        return EXIT_FAILED
    except KeyboardInterrupt:
        print("frangible: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED


class _Parser(argparse.ArgumentParser):
    """Answers bad arguments with one sentence."""

    def error(self, message: str) -> NoReturn:
        print(f"{self.prog}: {message}", file=sys.stderr)
        sys.exit(EXIT_BAD_INPUT)


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="frangible", description="Rigid bodies that break.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    defaults = _frangible.shot_defaults()
    run = commands.add_parser("run", help="simulate a shot and write what it looks like")
    run.set_defaults(command=_run)
    run.add_argument("shot", metavar="SHOT", help="one of those that `frangible shots` lists")
    run.add_argument("--mesh", metavar="FILE", help="mesh, for shots that break one")
    run.add_argument("--frames", type=_positive(int, "a whole number"), metavar="N", help="number of steps [the shot's]")
    run.add_argument(
        "--fps", type=_positive(float, "a number"), default=defaults["fps"], metavar="HZ", help="steps per second [%(default)g]"
    )
    run.add_argument("--method", default=defaults["method"], help="which step advances a frame [%(default)s]")
    run.add_argument("--threads", type=_natural(MOST_THREADS), default=0, metavar="N", help="0 means one for every processor [0]")
    run.add_argument("--seed", type=_natural(2**64 - 1), default=defaults["seed"], metavar="N", help="same seed, same run [%(default)s]")
    run.add_argument(
        "--out", action="append", default=[], metavar="FILE", help=".usda, .usdc, .glb, .npz or .png; may be repeated"
    )
    run.add_argument("--frame", type=_natural(2**63 - 1), metavar="N", help="frame that a .png shows [the last]")
    run.add_argument("--json", action="store_true", help="end with one line of JSON on stdout")

    _add_bench(commands)
    _add_break(commands)

    plot = commands.add_parser("plot", help="draw energy by cause and momentum over time")
    plot.set_defaults(command=_plot)
    plot.add_argument("file", metavar="FILE", help="what `frangible run --out FILE` wrote, .npz")
    plot.add_argument(
        "--out", action="append", required=True, metavar="FILE", help=".png, .svg or .pdf; may be repeated"
    )

    verify = commands.add_parser("verify", help="measure what the paper and we promise; status 1 if something does not hold")
    verify.set_defaults(command=_verify)
    verify.add_argument("claims", nargs="*", metavar="CLAIM", help="names from the table's first column [all]")
    verify.add_argument("--json", action="store_true", help="one JSON object instead of the table")

    pattern = commands.add_parser(
        "pattern",
        help="make a fracture pattern, save it and draw it with its pieces pulled apart",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="kinds:\n" + "\n".join(f"  {name:10} {line}" for name, line in _frangible.patterns()),
    )
    pattern.set_defaults(command=_pattern)
    pattern.add_argument("name", metavar="NAME", help="a kind listed below, or a file: a saved pattern (.json) or a mesh whose closed parts fill a box (.obj, .gltf, .glb, .usd)")
    pattern.add_argument("--cells", type=_positive(int, "a whole number"), metavar="N", help="about so many pieces [the kind's]")
    pattern.add_argument("--seed", type=_natural(2**64 - 1), metavar="N", help="same seed, same pattern [1]")
    pattern.add_argument(
        "--out", action="append", default=[], metavar="FILE", help=".json, or .png for a picture; may be repeated"
    )
    pattern.add_argument("--picture", metavar="FILE", help="a picture beside what --out writes, .png")

    shots = commands.add_parser("shots", help="list the shots")
    shots.set_defaults(command=_shots)

    info = commands.add_parser("info", help="describe a mesh, with its mass properties at unit density, or a cache")
    info.set_defaults(command=_info)
    info.add_argument("file", metavar="FILE", help="mesh (.obj, .ply, .stl, .gltf, .glb, .usd) or cache (.npz, .usda, .usdc)")
    return parser


def _add_bench(commands: Any) -> None:
    bencher = commands.add_parser("bench", help="measure how long the stages of a frame take, and how much memory a piece")
    bencher.set_defaults(command=_bench)
    bencher.add_argument("shot", metavar="SHOT", nargs="?", help="one of those that `frangible shots` lists, or all [the piles, and some small ones]")
    bencher.add_argument("--frames", type=_positive(int, "a whole number"), metavar="N", help="number of steps [each shot's]")
    bencher.add_argument(
        "--threads", type=_naturals(MOST_THREADS), default=[1], metavar="N[,N]", help="0 means one for every processor; of several, each in turn [1]"
    )
    bencher.add_argument("--peers", action="store_true", help="piles in other engines too, on one core; from the root of the repository")
    bencher.add_argument("--runs", type=_positive(int, "a whole number"), default=3, metavar="N", help="of each engine with --peers, by turns [%(default)s]")
    bencher.add_argument("--out", default=RESULTS, metavar="FOLDER", help="where the table goes that results are appended to [%(default)s]")
    bencher.add_argument("--json", action="store_true", help="one line of JSON on stdout for every shot, instead of its table")


def _add_break(commands: Any) -> None:
    breaker = commands.add_parser("break", help="break a mesh into pieces, without a simulation")
    breaker.set_defaults(command=_break)
    breaker.add_argument("mesh", metavar="MESH", help="mesh (.obj, .ply, .stl, .gltf, .glb, .usd)")
    breaker.add_argument("--pattern", required=True, metavar="NAME|FILE", help="built-in pattern, or a file that holds one")
    breaker.add_argument("--cells", type=_positive(int, "a whole number"), metavar="N", help="number of cells [the pattern's]")
    breaker.add_argument("--seed", type=_natural(2**64 - 1), metavar="N", help="same seed, same pieces [the pattern's]")
    breaker.add_argument(
        "--at",
        nargs=3,
        type=_finite,
        metavar=("X", "Y", "Z"),
        help="point that is struck, in the mesh's own frame [where a blow through the middle of the bounding box lands]",
    )
    breaker.add_argument(
        "--normal",
        nargs=3,
        type=_finite,
        default=DEFAULT_NORMAL,
        metavar=("X", "Y", "Z"),
        help="from the point towards what strikes it [0 1 0: struck from above]",
    )
    breaker.add_argument("--exact", action="store_true", help="cut the mesh's own triangles, not samples of it on a grid")
    breaker.add_argument(
        "--voxels",
        type=_natural(MOST_VOXELS),
        default=DEFAULT_VOXELS,
        metavar="N",
        help="of the grid, along the mesh's longest side [%(default)s]; with --exact only for a mesh that must be closed so",
    )
    breaker.add_argument(
        "--out",
        required=True,
        metavar="FILE|FOLDER",
        help=".glb, .gltf, .usda, .usdc, .usd, .obj, or a folder of .obj; volumes, centres and neighbours go beside it as .json",
    )
    breaker.add_argument("--json", action="store_true", help="end with one line of JSON on stdout")


def _finite(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r}, must be a finite number")
    return value


def _positive(kind: Callable[[str], Any], noun: str) -> Callable[[str], Any]:
    def parse(text: str) -> Any:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not 0 < value < math.inf:
            raise argparse.ArgumentTypeError(f"{text!r}, must be {noun} > 0")
        return value

    return parse


def _natural(largest: int) -> Callable[[str], int]:
    def parse(text: str) -> int:
        if not text.isdecimal() or int(text) > largest:
            raise argparse.ArgumentTypeError(f"{text!r}, must be a whole number >= 0 and <= {largest}")
        return int(text)

    return parse


def _naturals(largest: int) -> Callable[[str], list[int]]:
    parse = _natural(largest)
    return lambda text: [parse(part) for part in text.split(",")]


def _run(options: argparse.Namespace) -> None:
    # Whatever can be wrong is found before anything is simulated.
    outputs = [open_output(path, options.frame) for path in options.out]
    frames = options.frames or _frangible.shot_frames(options.shot, options.fps)
    if options.frame is not None and options.frame > frames:
        raise OutputError(f"--frame: {options.frame}, must be at most the number of frames, {frames}")
    if options.frame is not None and not any(path.lower().endswith(".png") for path in options.out):
        raise OutputError(f"--frame: {options.frame}, must come with an --out that ends in .png")
    # The scene names the mesh's file: `build` reads it once more.
    with nullcontext() if options.mesh is None else readable_mesh(options.mesh) as mesh:
        scene = _frangible.shot_scene(options.shot, mesh=mesh, fps=options.fps, method=options.method, seed=options.seed)
        world = _frangible.World.build(scene, options.threads)

    # Simulate; surfaces are made and kept only if a file needs them.
    start_bodies, start_mass = len(world.ids), moving_mass(world)
    start_energy = world.energy
    recorder = Recorder(world) if outputs else None
    reports: list[StepReport] = []
    depths: list[npt.NDArray[np.float64]] = []

    def keep(report: StepReport) -> None:
        reports.append(report)
        depths.append(world.penetrations())
        if recorder is not None:
            recorder.capture(report)

    with report_progress(frames) as progress:
        step_ms = step_frames(world, frames, on_step=keep, progress=progress)

    # Write the files, then the figures.
    if recorder is not None:
        _write(outputs, recorder.finish(options.shot, options.fps))
    summary = summarise(
        reports,
        shot=options.shot,
        method=options.method,
        dt=world.dt,
        state_hash=world.state_hash(),
        bodies=(start_bodies, len(world.ids)),
        mass=(start_mass, moving_mass(world)),
        energy=start_energy,
        depths=depths,
        step_ms=step_ms,
    )
    print(json.dumps(summary) if options.json else describe(summary, 1e-3 * sum(step_ms)))


def _bench(options: argparse.Namespace) -> None:
    def say(summary: Summary) -> None:
        print(json.dumps(summary) if options.json else describe_bench(summary), flush=True)

    if options.peers:
        from .peers import PILES, compare, describe_peers

        piles = PILES if options.shot is None else shots_to_bench(options.shot)

        def show(rows: list[dict[str, Any]]) -> None:
            print(json.dumps(rows) if options.json else describe_peers(rows), flush=True)

        compare(piles, frames=options.frames, runs=options.runs, folder=options.out, on_done=show)
        return
    shots = shots_to_bench(options.shot)
    bench(shots, frames=options.frames, threads=options.threads, folder=options.out, on_done=say)


def _write(outputs: list[Output], recording: Recording) -> None:
    for output in outputs:
        output.write(recording)
        size = os.path.getsize(output.path)
        print(f"wrote {output.path}, {size / 2**20:.3g} MiB", file=sys.stderr)


def _break(options: argparse.Namespace) -> None:
    output = open_pieces_output(options.out)
    with readable_mesh(options.pattern) as name:
        pattern = _frangible.Pattern.named(name, cells=options.cells, seed=options.seed)
    begin = time.perf_counter()
    pieces = break_mesh(
        options.mesh,
        pattern,
        at=options.at,
        normal=options.normal,
        exact=options.exact,
        voxels=options.voxels,
    )
    summary = pieces.summary(time.perf_counter() - begin)
    output.write(pieces)
    print(f"wrote {output.path} and {output.report}", file=sys.stderr)
    print(json.dumps(summary) if options.json else describe_pieces(summary))


def _plot(options: argparse.Namespace) -> None:
    outputs = [open_plot(path) for path in options.out]
    _write(outputs, Recording.load(options.file))


def _verify(options: argparse.Namespace) -> int:
    def say(*lines: str) -> None:
        if not options.json:
            print("\n".join(lines), flush=True)

    # The table grows as claims are measured.
    verdicts: list[Verdict] = []
    for verdict in verify(*options.claims, on_done=_tell):
        say(*([] if verdicts else table_head()), *table_rows(verdict))
        verdicts.append(verdict)
    if options.json:
        print(json.dumps(as_json(verdicts), allow_nan=False))
    return 0 if all(verdict.holds for verdict in verdicts) else EXIT_FAILED


def _tell(verdict: Verdict) -> None:
    result = "holds" if verdict.holds else "does not hold"
    print(f"{verdict.claim} {result}, measured in {verdict.seconds:.3g} s", file=sys.stderr, flush=True)


def _pattern(options: argparse.Namespace) -> None:
    from .pattern import check_pattern_file, describe_pattern, write_pattern

    # Whatever can be wrong is found before anything is drawn.
    if options.picture is not None and not options.picture.lower().endswith(".png"):
        raise OutputError(f"--picture: {options.picture}, must end in .png")
    paths = [*options.out, *([options.picture] if options.picture is not None else [])]
    for path in paths:
        check_pattern_file(path)
    with readable_mesh(options.name) as name:
        pattern = _frangible.Pattern.named(name, cells=options.cells, seed=options.seed)
    for key, value in describe_pattern(pattern).items():
        print(f"{key:15} {_readable(value)}")
    for path in paths:
        write_pattern(pattern, path)
        print(f"wrote {path}, {os.path.getsize(path) / 2**20:.3g} MiB", file=sys.stderr)


def _shots(_: argparse.Namespace) -> None:
    shots = _frangible.shots()
    width = max((len(name) for name, _ in shots), default=0)
    for name, line in shots:
        print(f"{name:{width}}  {line}")


def _info(options: argparse.Namespace) -> None:
    from .info import describe_file

    for key, value in describe_file(options.file).items():
        print(f"{key:15} {_readable(value)}")


def _readable(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        between = "; " if value and isinstance(value[0], list) else " "
        return between.join(_readable(item) for item in value)
    return str(value)
