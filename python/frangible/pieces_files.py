"""Files of a broken mesh: one writer for each ending, and the report beside them as JSON."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .materials import INSIDE, OUTSIDE, Colour
from .output import OutputError, check_destination, check_folder
from .pieces import Piece, Pieces
from .whole import whole_file, whole_folder

#: Names of the two materials.
OUTER, INNER = "outer", "inner"
#: The extra of the installation that each ending needs.
_EXTRAS = {".glb": None, ".gltf": None, ".obj": None, ".usd": "usd", ".usda": "usd", ".usdc": "usd"}
#: What a folder of ours holds.
_OURS = re.compile(r"piece_\d{3,}\.obj|materials\.mtl|pieces\.json")


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


def open_pieces_output(path: str) -> PiecesOutput:
    """Check that pieces can be written there, before anything is broken; `OutputError` if not."""
    stem, ending = os.path.splitext(path)
    if ending == "" or path.endswith(os.sep) or os.path.isdir(path):
        return _open_folder(path)
    ending = check_destination(path, _EXTRAS, "or a folder, which ends in /")
    return PiecesOutput(path, {".obj": _write_obj, ".glb": _write_glb, ".gltf": _write_glb}.get(ending, _write_usd), stem + ".json")


def _open_folder(path: str) -> PiecesOutput:
    above = os.path.dirname(os.path.realpath(path))
    if os.path.isdir(path):
        if os.path.samefile(path, os.curdir):
            raise OutputError(f"{path}: is the folder that the command runs in, must be another one")
        foreign = sorted(name for name in os.listdir(path) if not _OURS.fullmatch(name))
        if foreign:
            raise OutputError(f"{path}: holds {foreign[0]!r}, must be new, empty, or hold the pieces of an earlier break only")
        if not os.access(path, os.W_OK | os.X_OK):
            raise OutputError(f"{path}: the folder cannot be written to")
        if not os.access(above, os.W_OK | os.X_OK):
            raise OutputError(f"{path}: the folder above, {above!r}, cannot be written to")
    elif os.path.exists(path):
        raise OutputError(f"{path}: is a file without a known ending, must be a folder or end in .glb, .gltf, .obj, .usd, .usda or .usdc")
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


def _write_obj(pieces: Pieces, path: str) -> None:
    materials = os.path.splitext(path)[0] + ".mtl"
    with whole_file(materials) as part:
        _write_materials(part)
    with whole_file(path) as part:
        _write_obj_file(pieces.pieces, part, os.path.basename(materials))


def _write_folder(pieces: Pieces, path: str) -> None:
    # What an earlier break left goes away at the end: it may have had more pieces.
    with whole_folder(path) as part:
        _write_materials(os.path.join(part, "materials.mtl"))
        for piece in pieces.pieces:
            _write_obj_file([piece], os.path.join(part, f"{piece.name}.obj"), "materials.mtl")
        _write_report(pieces, os.path.join(part, "pieces.json"))


def _write_report(pieces: Pieces, path: str) -> None:
    with open(path, "w", encoding="utf-8") as file:
        json.dump(pieces.report(), file, indent=1)


def _write_materials(path: str) -> None:
    def material(name: str, colour: Colour) -> str:
        return f"newmtl {name}\nKd {' '.join(f'{channel:g}' for channel in colour)}\n"

    with open(path, "w", encoding="utf-8") as file:
        file.write(material(OUTER, OUTSIDE[0]) + material(INNER, INSIDE))


def _write_obj_file(pieces: list[Piece], path: str, materials: str) -> None:
    """One object for each piece; the faces of the cracks have texture coordinates."""
    lines = [f"mtllib {materials}"]
    vertex, coordinate = 1, 1
    for piece in pieces:
        lines.append(f"o {piece.name}")
        # Python's shortest digits read back to the same numbers.
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in piece.vertices.tolist()]
        outer = piece.triangles[~piece.inner] + vertex
        if len(outer):
            lines.append(f"usemtl {OUTER}")
            lines += [f"f {a} {b} {c}" for a, b, c in outer.tolist()]
        inner = piece.triangles[piece.inner] + vertex
        if len(inner):
            places, index = np.unique(piece.coordinates[piece.inner].reshape(-1, 2), axis=0, return_inverse=True)
            lines += [f"vt {u:.7g} {v:.7g}" for u, v in places.tolist()]
            lines.append(f"usemtl {INNER}")
            corners = zip(inner.tolist(), (index.reshape(-1, 3) + coordinate).tolist(), strict=True)
            lines += [f"f {a}/{p} {b}/{q} {c}/{r}" for (a, b, c), (p, q, r) in corners]
            coordinate += len(places)
        vertex += len(piece.vertices)
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
