"""``frangible plot``, ``shots`` and ``info``: what there is."""

from __future__ import annotations

import argparse
import json
from typing import Any

from .. import _frangible
from ..io.output import open_plot
from ..progress import report_stages
from ..recording import Recording
from .options import add_pose_time, readable
from .outputs import write
from .shot_groups import grouped
from .terminal import show


def add_plot(commands: Any) -> None:
    """Add the command."""
    plot = commands.add_parser("plot", help="draw energy by cause and momentum over time")
    plot.set_defaults(command=_plot)
    plot.add_argument("file", metavar="FILE", help="what `frangible run --out FILE` wrote, .npz")
    plot.add_argument(
        "--out",
        action="append",
        required=True,
        metavar="FILE",
        help=".png, .svg or .pdf; may be repeated",
    )


def add_shots(commands: Any) -> None:
    """Add the command."""
    shots = commands.add_parser("shots", help="list the shots by what they show")
    shots.set_defaults(command=_shots)
    shots.add_argument(
        "--json", action="store_true", help="a JSON object instead: the line of each name"
    )


def add_info(commands: Any) -> None:
    """Add the command."""
    info = commands.add_parser(
        "info", help="describe a mesh, with its mass properties at unit density, or a cache"
    )
    info.set_defaults(command=_info)
    add_pose_time(info)
    info.add_argument("--json", action="store_true", help="a JSON object instead")
    info.add_argument(
        "file",
        metavar="FILE",
        help="mesh (.obj, .ply, .stl, .gltf, .glb, .usd) or cache (.npz, .usda, .usdc)",
    )


def _plot(options: argparse.Namespace) -> int:
    outputs = [open_plot(path) for path in options.out]
    return write(outputs, Recording.load(options.file), as_json=options.json)


def _shots(options: argparse.Namespace) -> None:
    shots = _frangible.shots()
    if options.json:
        print(json.dumps(dict(shots)))
        return
    width = max((len(name) for name, _ in shots), default=0)
    for index, (title, group) in enumerate(grouped(shots)):
        print(f"{title}:" if index == 0 else f"\n{title}:")
        for name, line in group:
            print(f"  {name:{width}}  {line}")


def _info(options: argparse.Namespace) -> None:
    from .info import describe_file

    with report_stages() as stage:
        stage("measuring what the file holds")
        facts = describe_file(options.file, options.pose_time)
    if options.json:
        print(json.dumps(facts))
        return
    for key, value in facts.items():
        show(f"{key:15} {readable(value)}")
