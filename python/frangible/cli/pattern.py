"""``frangible pattern``: make a fracture pattern, save it and draw it."""

from __future__ import annotations

import argparse
import json
import os
from typing import Any

from .. import _frangible
from ..breaking.piece_count import MOST_PIECES
from ..errors import OutputError
from ..io.mesh_files import readable_mesh
from .options import check_pieces, count, natural, readable
from .terminal import say, show


def add_pattern(commands: Any) -> None:
    """Add the command."""
    pattern = commands.add_parser(
        "pattern",
        help="make a fracture pattern, save it and draw it with its pieces pulled apart",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="kinds:\n"
        + "\n".join(f"  {name:10} {line}" for name, line in _frangible.patterns()),
    )
    pattern.set_defaults(command=_pattern)
    pattern.add_argument(
        "name",
        metavar="NAME",
        help="a kind listed below, or a file: a saved pattern (.json) or a mesh whose closed "
        "parts fill a box (.obj, .gltf, .glb, .usd)",
    )
    pattern.add_argument(
        "--cells", type=count, metavar="N", help="about so many pieces [the kind's]"
    )
    pattern.add_argument(
        "--pieces",
        type=natural(MOST_PIECES),
        metavar="N",
        help="so many pieces, as nearly as the kind has them [the cells']",
    )
    pattern.add_argument(
        "--seed", type=natural(2**64 - 1), metavar="N", help="same seed, same pattern [1]"
    )
    pattern.add_argument(
        "--out",
        action="append",
        default=[],
        metavar="FILE",
        help=".json, or .png for a picture; may be repeated",
    )
    pattern.add_argument("--json", action="store_true", help="a JSON object instead of lines")
    pattern.add_argument(
        "--picture", metavar="FILE", help="a picture beside what --out writes, .png"
    )


def _pattern(options: argparse.Namespace) -> None:
    from ..breaking.pattern import check_pattern_file, describe_pattern, write_pattern
    from ..breaking.piece_count import difference

    check_pieces(options.pieces, options.cells)

    # Whatever can be wrong is found before anything is drawn.
    if options.picture is not None and not options.picture.lower().endswith(".png"):
        raise OutputError(f"--picture: {options.picture}, must end in .png")
    paths = [*options.out, *([options.picture] if options.picture is not None else [])]
    for path in paths:
        check_pattern_file(path)
    with readable_mesh(options.name) as name:
        pattern = _frangible.Pattern.named(name, cells=options.cells, seed=options.seed)
    if options.pieces is not None:
        pattern, count = pattern.with_pieces(options.pieces)
        if sentence := difference(count, options.pieces):
            say(sentence)
    facts = describe_pattern(pattern)
    if options.json:
        print(json.dumps(facts))
    else:
        show("\n".join(f"{key:15} {readable(value)}" for key, value in facts.items()))
    for path in paths:
        write_pattern(pattern, path)
        say(f"wrote {path}, {os.path.getsize(path) / 2**20:.3g} MiB")
