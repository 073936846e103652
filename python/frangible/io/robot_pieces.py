"""Pieces at rest for other simulators: MJCF and URDF, with their meshes in a folder beside."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable
from xml.etree import ElementTree

import numpy as np

from ..pieces import Piece, Pieces
from ..recording import Float64, UInt32
from ..words import counted
from .convex_parts import convex_parts
from .reading import FileNote
from .robot_files import mesh_folder
from .whole import whole_file, whole_folder, whole_path

#: [m/s^2].
_GRAVITY = 9.81

#: MuJoCo 4.0 refuses bodies with a smaller principal inertia [kg m^2].
LEAST_INERTIA = 1e-14

Element = ElementTree.Element


def write_mjcf(pieces: Pieces, path: str, density: float) -> None:
    """A model for MuJoCo, in the mesh's own axes, on a plane where it is lowest: y is up."""
    _write(pieces, path, _mjcf, density)


def write_urdf(pieces: Pieces, path: str, density: float) -> None:
    """A robot whose links float, z up: the mesh's y."""
    _write(pieces, path, _urdf, density)


def _write(
    pieces: Pieces, path: str, build: Callable[[Pieces, dict[str, list[str]], str, float], Element],
    density: float,
) -> None:  # fmt: skip
    folder = mesh_folder(path)
    if small := sum(_is_too_small(piece, density) for piece in pieces.pieces):
        warnings.warn(
            f"{whole_path(path)}: {counted(small, 'piece')} with a principal inertia below "
            f"{LEAST_INERTIA:g} kg m^2, which MuJoCo refuses; --smallest merges small ones",
            FileNote,
            stacklevel=2,
        )
    with whole_folder(folder) as meshes, whole_file(path) as part:
        names = {piece.name: _write_meshes(piece, meshes) for piece in pieces.pieces}
        tree = build(pieces, names, os.path.basename(folder), density)
        ElementTree.indent(tree)
        ElementTree.ElementTree(tree).write(part, "utf-8", xml_declaration=True)


def _write_meshes(piece: Piece, folder: str) -> list[str]:
    """The piece, and its convex parts where it is not one itself: the names of these."""
    parts = convex_parts(piece)
    _write_obj(os.path.join(folder, f"{piece.name}.obj"), piece.vertices - piece.center,
               piece.triangles)  # fmt: skip
    names = [f"{piece.name}_part_{number}" for number in range(len(parts))]
    for name, (vertices, triangles) in zip(names, parts, strict=True):
        _write_obj(os.path.join(folder, f"{name}.obj"), vertices, triangles)
    return names


def _write_obj(path: str, vertices: Float64, triangles: UInt32) -> None:
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (triangles.astype(np.int64) + 1).tolist()]
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def _numbers(*values: float) -> str:
    """Shortest digits that read back to the same numbers."""
    return " ".join(repr(float(value) + 0.0) for value in values)


def _inertia(piece: Piece, density: float) -> dict[str, float]:
    """About the centre of mass, in the mesh's axes [kg m^2]."""
    tensor = density * piece.unit_inertia
    tensor = (tensor + tensor.T) / 2.0
    axes = "xyz"
    return {
        f"i{axes[row]}{axes[column]}": float(tensor[row, column])
        for row in range(3)
        for column in range(row, 3)
    }


def _is_too_small(piece: Piece, density: float) -> bool:
    return float(np.linalg.eigvalsh(piece.unit_inertia)[0]) * density < LEAST_INERTIA


def _mjcf(pieces: Pieces, parts: dict[str, list[str]], folder: str, density: float) -> Element:
    model = Element("mujoco", model=pieces.name)
    child = ElementTree.SubElement
    child(model, "compiler", angle="radian", meshdir=folder)
    child(model, "option", gravity=_numbers(0.0, -_GRAVITY, 0.0))
    asset = child(model, "asset")
    world = child(model, "worldbody")
    lowest = min(float(piece.vertices[:, 1].min()) for piece in pieces.pieces)
    child(world, "geom", name="ground", type="plane", size="0 0 1", zaxis="0 1 0",
          pos=_numbers(0.0, lowest, 0.0))  # fmt: skip
    for piece in pieces.pieces:
        # What a mesh weighs by itself is not asked: the inertia is told.
        for name in (piece.name, *parts[piece.name]):
            child(asset, "mesh", name=name, file=f"{name}.obj", inertia="convex")
        body = child(world, "body", name=piece.name, pos=_numbers(*piece.center))
        child(body, "freejoint")
        tensor = _inertia(piece, density)
        full = [tensor[key] for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")]
        mass = _numbers(density * piece.volume)
        child(body, "inertial", pos="0 0 0", mass=mass, fullinertia=_numbers(*full))
        child(body, "geom", type="mesh", mesh=piece.name, contype="0", conaffinity="0", group="2")
        for name in parts[piece.name]:
            child(body, "geom", type="mesh", mesh=name, group="3")
    return model


def _urdf(pieces: Pieces, parts: dict[str, list[str]], folder: str, density: float) -> Element:
    robot = Element("robot", name=pieces.name)
    child = ElementTree.SubElement
    # MuJoCo reads URDF, too.
    extension = child(robot, "mujoco")
    child(extension, "compiler", strippath="false", discardvisual="false")
    child(robot, "link", name="world")
    for piece in pieces.pieces:
        link = child(robot, "link", name=piece.name)
        inertial = child(link, "inertial")
        child(inertial, "origin", xyz="0 0 0", rpy="0 0 0")
        child(inertial, "mass", value=_numbers(density * piece.volume))
        tensor = {key: _numbers(value) for key, value in _inertia(piece, density).items()}
        child(inertial, "inertia", tensor)
        for kind, names in (("visual", [piece.name]), ("collision", parts[piece.name])):
            for name in names:
                shape = child(child(link, kind), "geometry")
                child(shape, "mesh", filename=f"{folder}/{name}.obj")
        joint = child(robot, "joint", name=f"{piece.name}_floats", type="floating")
        child(joint, "parent", link="world")
        child(joint, "child", link=piece.name)
        # y goes up to z.
        x, y, z = piece.center
        child(joint, "origin", xyz=_numbers(x, -z, y), rpy=_numbers(math.pi / 2.0, 0.0, 0.0))
    return robot
