"""Files of a broken mesh: one writer for each ending, and the report beside them as JSON."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from ..errors import OutputError
from ..pieces import Pieces
from .output import check_destination, check_folder
from .robot_files import DEFAULT_DENSITY, check_mesh_folder
from .whole import whole_file, whole_folder

#: The extra of the installation that each ending needs.
_EXTRAS = {
    ".glb": None,
    ".gltf": None,
    ".obj": None,
    ".urdf": "exact",
    ".usd": "usd",
    ".usda": "usd",
    ".usdc": "usd",
    ".xml": "exact",
}
#: Contents of a folder of ours.
_OURS = re.compile(r"piece_\d{3,}\.obj|materials\.mtl|pieces\.json|textures")


@dataclass(frozen=True, slots=True)
class PiecesOutput:
    """A checked destination, ready to be written."""

    path: str
    writer: Callable[[Pieces, str], None]
    #: Where the report goes.
    report: str

    def write(self, pieces: Pieces) -> None:
        """Write pieces and report; an `OSError` names the file."""
        try:
            os.makedirs(os.path.dirname(self.path) or ".", exist_ok=True)
            self.writer(pieces, self.path)
            if self.writer is not _write_folder:
                with whole_file(self.report) as part:
                    _write_report(pieces, part)
        except OSError as error:
            raise OSError(error.errno, error.strerror or str(error), self.path) from error


def open_pieces_output(path: str, density: float = DEFAULT_DENSITY) -> PiecesOutput:
    """Check that pieces can be written there, before anything is broken; `OutputError` if not.

    The density is that of files for other simulators [kg/m^3].
    """
    stem, ending = os.path.splitext(path)
    if ending == "" or path.endswith(os.sep) or os.path.isdir(path):
        return _open_folder(path)
    ending = check_destination(path, _EXTRAS, "or a folder, which ends in /")
    if ending in (".urdf", ".xml"):
        check_mesh_folder(path)
        return PiecesOutput(path, partial(_write_robot, density=density), stem + ".json")
    return PiecesOutput(
        path,
        {".obj": _write_obj, ".glb": _write_glb, ".gltf": _write_glb}.get(ending, _write_usd),
        stem + ".json",
    )


def _open_folder(path: str) -> PiecesOutput:
    above = os.path.dirname(os.path.realpath(path))
    if os.path.isdir(path):
        if os.path.samefile(path, os.curdir):
            raise OutputError(
                f"{path}: is the folder that the command runs in, must be another one"
            )
        foreign = sorted(name for name in os.listdir(path) if not _OURS.fullmatch(name))
        if foreign:
            raise OutputError(
                f"{path}: holds {foreign[0]!r}, must be new, empty, or hold the pieces of an "
                "earlier break only"
            )
        if not os.access(path, os.W_OK | os.X_OK):
            raise OutputError(f"{path}: the folder cannot be written to")
        if not os.access(above, os.W_OK | os.X_OK):
            raise OutputError(f"{path}: the folder above, {above!r}, cannot be written to")
    elif os.path.exists(path):
        raise OutputError(
            f"{path}: is a file without a known ending, must be a folder or end in .glb, .gltf, "
            ".obj, .urdf, .usd, .usda, .usdc or .xml"
        )
    else:
        check_folder(path, above)
    return PiecesOutput(path, _write_folder, os.path.join(path, "pieces.json"))


def _write_glb(pieces: Pieces, path: str) -> None:
    from .gltf import write_pieces

    with whole_file(path) as part:
        write_pieces(pieces, part)


def _write_usd(pieces: Pieces, path: str) -> None:
    from .usd import write_pieces

    with whole_file(path) as part:
        write_pieces(pieces, part)


def _write_robot(pieces: Pieces, path: str, density: float) -> None:
    from .robot_pieces import write_mjcf, write_urdf

    write = write_urdf if path.lower().endswith(".urdf") else write_mjcf
    write(pieces, path, density)


def _write_obj(pieces: Pieces, path: str) -> None:
    from .obj_pieces import write_obj

    materials = os.path.splitext(path)[0] + ".mtl"
    with whole_file(materials) as materials_part, whole_file(path) as part:
        write_obj(pieces, part, materials_part, os.path.basename(materials))


def _write_folder(pieces: Pieces, path: str) -> None:
    from .obj_pieces import write_folder

    # The files of an earlier break go away at the end: it may have had more pieces.
    with whole_folder(path) as part:
        write_folder(pieces, part)
        _write_report(pieces, os.path.join(part, "pieces.json"))


def _write_report(pieces: Pieces, path: str) -> None:
    with open(path, "w", encoding="utf-8") as file:
        json.dump(pieces.report(), file, indent=1)
