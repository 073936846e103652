"""``frangible scene``: a scene to start from."""

from __future__ import annotations

import argparse
from typing import Any

from ..scenes import as_json, find_scene
from .options import add_scene_options


def add_scene(commands: Any) -> None:
    """Add the command."""
    scene = commands.add_parser("scene", help="print the scene of a shot as JSON, to start one of your own from")
    scene.set_defaults(command=_scene)
    add_scene_options(scene)


def _scene(options: argparse.Namespace) -> None:
    scene, *_ = find_scene(
        options.shot,
        mesh=options.mesh,
        fps=options.fps,
        method=options.method,
        seed=options.seed,
        assignments=options.assignments,
    )
    print(as_json(scene))
