"""``frangible view``: play a recording, or a run while it is simulated, in the browser."""

from __future__ import annotations

import argparse
import os
import sys
import threading
import webbrowser
from typing import Any

from .. import _frangible
from ..io.live_reel import Chunks, LiveReel
from ..io.page import page_of, streaming_page
from ..io.page_server import PageServer
from ..io.view_file import read_recording
from ..progress import report_progress, report_stages
from ..recorder import Known, Recorder
from ..recording import Recording, step_frames
from ..scene_skins import scene_skins
from ..scenes import readable_scene
from ..simulation import check_bodies
from .options import add_inside, add_run_options, add_scene_options, chosen_scene
from .results import print_json
from .wishes import add_wishes, wished


def add_view_command(commands: Any) -> None:
    """Add the command."""
    view = commands.add_parser(
        "view", help="play a recording in the browser, or a shot or scene while it is simulated"
    )
    view.set_defaults(command=_view)
    add_scene_options(
        view, "a recording (.npz, .usda, .usdc, .glb, or the folder of a run that was stopped), or "
    )
    add_wishes(view)
    add_run_options(view)
    add_inside(view, "inside, or the look's own")
    view.add_argument(
        "--no-open", action="store_true", help="open no browser: the address is on stdout"
    )
    view.add_argument("--quiet", action="store_true", help="no progress")


def _view(options: argparse.Namespace) -> int:
    recording = read_recording(options.shot)
    try:
        if recording is not None:
            with PageServer(page_of(recording)) as server:
                _tell(options, server)
                _wait(options)
        else:
            _simulate(options)
    except KeyboardInterrupt:
        # That is how it is meant to end.
        pass
    return 0


def _simulate(options: argparse.Namespace) -> None:
    scene, frames, name = chosen_scene(options, wished(options))
    frames = options.frames or frames
    with (
        readable_scene(scene, options.pose_time) as readable,
        report_stages(options.quiet) as stage,
    ):
        stage("building the world")
        world = _frangible.World.build(readable, options.threads)
        check_bodies(world)
        skins = scene_skins(scene, readable, options.inside)
    rate = float(scene.get("frames_per_second", 0.0)) or 1.0 / world.dt

    chunks, known = Chunks(), Known()
    reel = LiveReel(chunks, known, skins, (name, world.method, rate))
    recorder = Recorder(world, None, reel, known)
    reel.send()
    with PageServer(streaming_page(name), chunks.follow) as server:
        _tell(options, server)

        def show(report: Any, _: float) -> None:
            recorder.capture(report)
            reel.send_when_due()

        with report_progress(frames, options.quiet) as progress:
            step_frames(world, frames, on_step=show, progress=progress)
        reel.send(is_last=True)
        chunks.close()
        _wait(options)


def _tell(options: argparse.Namespace, server: PageServer) -> None:
    """Say where the page is, and open it."""
    if options.json:
        print_json({"address": server.address})
    else:
        print(server.address, flush=True)
    if not options.no_open:
        # Some browsers keep the call until they are closed.
        opening = threading.Thread(target=webbrowser.open, args=[server.address], daemon=True)
        opening.start()


def _wait(options: argparse.Namespace) -> None:
    """Until somebody ends the command."""
    if not options.quiet:
        print("frangible: press Ctrl-C to end", file=sys.stderr, flush=True)
    threading.Event().wait()
