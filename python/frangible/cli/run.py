"""``frangible run``: simulate, and write what it looks like."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from typing import Any

from .. import _frangible
from ..bench.run_process import moving_mass
from ..bench.summary import RunFigures, describe
from ..errors import OutputError
from ..interrupts import Stop, stop_when_asked
from ..laid import Laid
from ..progress import report_progress, report_stages
from ..recording import step_frames
from ..report import StepReport
from ..scene_lines import convention_of
from ..scene_skins import scene_skins, volume_notes
from ..scenes import readable_scene
from ..simulation import check_bodies
from .kept_run import KeptRun, Start
from .options import (
    add_inside,
    add_run_options,
    add_scene_options,
    add_view,
    chosen_scene,
    natural,
)
from .outputs import check_view, open_outputs, write
from .terminal import say, show
from .wishes import add_wishes, wished


def add_run(commands: Any) -> None:
    """Add the command."""
    run = commands.add_parser(
        "run", help="simulate a shot or a scene of your own, and write what it looks like"
    )
    run.set_defaults(command=_run)
    add_scene_options(run)
    add_wishes(run)
    add_run_options(run)
    run.add_argument(
        "--out",
        action="append",
        default=[],
        metavar="FILE",
        help=".html plays it; .usda, .usdc, .usdz, .glb, .abc, .npz, .png, a film .mp4 or .gif, or "
        "folder/ for its frames; may be repeated",
    )
    add_inside(run, "inside, or the look's own")
    add_view(run)
    run.add_argument(
        "--frame", type=natural(2**63 - 1), metavar="N", help="frame that a .png shows [the last]"
    )
    run.add_argument(
        "--resume",
        action="store_true",
        help="go on with a run that was stopped: the same command with this, to the same bits",
    )
    run.add_argument(
        "--quiet", action="store_true", help="no progress and no list of what was written"
    )
    run.add_argument("--json", action="store_true", help="end with one line of JSON on stdout")


def _run(options: argparse.Namespace) -> int:
    # Whatever can be wrong is found before anything is simulated.
    outputs = open_outputs(options)
    if options.resume and not outputs:
        raise OutputError("--resume: must come with the --out of the run that it goes on with")
    scene, frames, name = chosen_scene(options, wished(options))
    frames = options.frames or frames
    check_view(options, convention_of(scene))
    _check_frame(options, frames)
    rate = float(scene.get("frames_per_second", 0.0))
    kept = KeptRun(options.out, [scene, options.inside]) if outputs else None
    resumed = kept.resume(frames) if kept is not None and options.resume else None
    world, skins = _build_world(scene, options, resumed)

    # Simulate: frames and surfaces go to a disk, and only if a file needs them.
    rate = rate or 1.0 / world.dt
    start = Start.of(world)
    figures = RunFigures()
    stop = Stop()
    try:
        if kept is not None:
            start = kept.open(world, skins, start, figures, (name, rate))

        def keep(report: StepReport, step_ms: float) -> None:
            depths = world.penetrations()
            figures.add(report, step_ms)
            figures.depths.add(depths)
            if kept is not None:
                kept.capture(report, step_ms, depths)

        with (
            report_progress(frames, options.quiet) as progress,
            stop_when_asked(world.stop_step) as stop,
        ):
            step_frames(
                world, frames, on_step=keep, progress=progress, stop=stop, done=world.frame
            )
    except OSError as error:
        if kept is None:
            raise
        return kept.give_up(error)
    if stop.signal is not None:
        said = f"stopped after {figures.frames} of {frames} frames"
        say(f"frangible: {said}; outputs are of those")

    # Write the files, then the figures.
    status = 0
    if kept is not None:
        try:
            recording = replace(kept.finish(), convention=convention_of(scene))
        except OSError as error:
            return kept.give_up(error)
        status = write(outputs, recording, options.quiet)
        del recording
        kept.close(is_complete=status == 0 and stop.signal is None)
    summary = figures.summary(
        shot=name,
        method=world.method,
        dt=world.dt,
        state_hash=world.state_hash(),
        bodies=(start.bodies, len(world.ids)),
        mass=(start.mass, moving_mass(world)),
        energy=start.energy,
    )
    seconds = 1e-3 * sum(figures.step_ms)
    if options.json:
        print(json.dumps(summary))
    else:
        show(describe(summary, seconds))
    return status if stop.signal is None else 128 + stop.signal


def _check_frame(options: argparse.Namespace, frames: int) -> None:
    """`OutputError` if ``--frame`` is beyond the run, or no picture shows it."""
    if options.frame is None:
        return
    if options.frame > frames:
        raise OutputError(
            f"--frame: {options.frame}, must be at most the number of frames, {frames}"
        )
    if not any(path.lower().endswith(".png") for path in options.out):
        raise OutputError(f"--frame: {options.frame}, must come with an --out that ends in .png")


def _build_world(
    scene: dict[str, Any], options: argparse.Namespace, resumed: bytes | None
) -> tuple[_frangible.World, dict[int, Laid]]:
    """The world of a scene, or that of the snapshot to go on from, and the skins of its bodies if
    an output shows them."""
    with (
        readable_scene(scene, options.pose_time) as readable,
        report_stages(options.quiet) as stage,
    ):
        if resumed is None:
            stage("building the world")
            world = _frangible.World.build(readable, options.threads)
        else:
            stage("reading the world")
            world = _frangible.World.restore(resumed, options.threads)
        check_bodies(world)
        skins = scene_skins(scene, readable, options.inside) if options.out else {}
        notes = volume_notes(readable, world.masses) if resumed is None else []
    for note in notes:
        say(f"frangible: {note}")
    return world, skins
