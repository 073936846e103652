"""``frangible break``: pieces of a mesh, without a simulation."""

from __future__ import annotations

import argparse
import json
import os
import time
from typing import Any

from .. import _frangible
from ..breaking.break_mesh import (
    DEFAULT_NORMAL,
    DEFAULT_SMALLEST,
    DEFAULT_VOXELS,
    MOST_VOXELS,
    break_mesh,
)
from ..breaking.piece_count import MOST_PIECES
from ..errors import OutputError
from ..io.mesh_files import readable_mesh
from ..io.pieces_output import open_pieces_output
from ..io.robot_files import DEFAULT_DENSITY
from ..pieces import describe_pieces
from ..progress import report_stages
from .options import (
    add_inside,
    add_pose_time,
    add_thickness,
    check_pieces,
    count,
    finite,
    natural,
    positive,
)
from .terminal import say, show


def add_break(commands: Any) -> None:
    """Add the command."""
    breaker = commands.add_parser("break", help="break a mesh into pieces, without a simulation")
    breaker.set_defaults(command=_break)
    breaker.add_argument("mesh", metavar="MESH", help="mesh (.obj, .ply, .stl, .gltf, .glb, .usd)")
    _add_cuts(breaker)
    _add_blow(breaker)
    _add_surface(breaker)
    _add_outputs(breaker)


def _add_cuts(breaker: argparse.ArgumentParser) -> None:
    """Options of the pattern, and of how many pieces it makes."""
    breaker.add_argument(
        "--pattern",
        required=True,
        metavar="NAME|FILE",
        help="built-in pattern, or a file that holds one",
    )
    breaker.add_argument("--cells", type=count, metavar="N", help="number of cells [the pattern's]")
    breaker.add_argument(
        "--pieces",
        type=natural(MOST_PIECES),
        metavar="N",
        help="about so many pieces: as many cells as that takes [what the cells make]",
    )
    breaker.add_argument(
        "--smallest",
        type=finite,
        default=DEFAULT_SMALLEST,
        metavar="FRACTION",
        help="smaller pieces join a neighbour; of the mean piece's volume [%(default)g]",
    )
    breaker.add_argument(
        "--seed",
        type=natural(2**64 - 1),
        metavar="N",
        help="same seed, same pieces [the pattern's]",
    )


def _add_blow(breaker: argparse.ArgumentParser) -> None:
    """Options of where the mesh is struck."""
    breaker.add_argument(
        "--at",
        nargs=3,
        type=finite,
        metavar=("X", "Y", "Z"),
        help="point that is struck, in the mesh's own frame [where a blow through the middle of "
        "the bounding box lands]",
    )
    breaker.add_argument(
        "--normal",
        nargs=3,
        type=finite,
        default=DEFAULT_NORMAL,
        metavar=("X", "Y", "Z"),
        help="from the point towards what strikes it [0 1 0: struck from above]",
    )


def _add_surface(breaker: argparse.ArgumentParser) -> None:
    """Options of how the mesh's surface is cut, and of what it looks like inside."""
    way = breaker.add_mutually_exclusive_group()
    way.add_argument(
        "--exact",
        action="store_const",
        const=True,
        help="fail if the mesh's own triangles cannot be cut [they are wherever that can be]",
    )
    way.add_argument(
        "--grid",
        dest="exact",
        action="store_const",
        const=False,
        help="make the mesh's surface anew on a grid before it is cut",
    )
    add_inside(breaker, "inner")
    breaker.add_argument(
        "--voxels",
        type=natural(MOST_VOXELS, 1),
        default=DEFAULT_VOXELS,
        metavar="N",
        help="of the grid, along the mesh's longest side [%(default)s]; of a mesh that crosses "
        "itself, or with --grid",
    )
    add_thickness(breaker)
    add_pose_time(breaker)


def _add_outputs(breaker: argparse.ArgumentParser) -> None:
    """Options of what is written and printed."""
    breaker.add_argument(
        "--density",
        type=positive,
        default=DEFAULT_DENSITY,
        metavar="KG/M3",
        help="of the pieces of an .xml or .urdf [%(default)g]",
    )
    breaker.add_argument(
        "--out",
        required=True,
        metavar="FILE|FOLDER",
        help=".glb, .gltf, .usda, .usdc, .usd, .obj, or a folder of .obj; MJCF .xml or .urdf for "
        "other simulators; volumes, centres and neighbours go beside it as .json",
    )
    breaker.add_argument("--quiet", action="store_true", help="no progress and no list of files")
    breaker.add_argument("--json", action="store_true", help="end with one line of JSON on stdout")


def _is_one_file(path: str, other: str) -> bool:
    return os.path.isfile(path) and os.path.exists(other) and os.path.samefile(path, other)


def _break(options: argparse.Namespace) -> None:
    check_pieces(options.pieces, options.cells)
    output = open_pieces_output(options.out, options.density)
    for written in (output.path, output.report):
        for source in (options.mesh, options.pattern):
            if _is_one_file(written, source):
                raise OutputError(f"--out: {written}: is what is read, must be another file")
    with readable_mesh(options.pattern) as name:
        pattern = _frangible.Pattern.named(name, cells=options.cells, seed=options.seed)
    begin = time.perf_counter()
    with report_stages(options.quiet) as stage:
        pieces = break_mesh(
            options.mesh,
            pattern,
            at=options.at,
            normal=options.normal,
            exact=options.exact,
            inside=options.inside,
            voxels=options.voxels,
            pieces=options.pieces,
            smallest=options.smallest,
            thickness=options.thickness,
            pose_time=options.pose_time,
            stage=stage,
        )
    summary = pieces.summary(time.perf_counter() - begin)
    output.write(pieces)
    if not options.quiet:
        say(f"wrote {output.path} and {output.report}")
    if options.json:
        print(json.dumps(summary))
    else:
        show(describe_pieces(summary))
