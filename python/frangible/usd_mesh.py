"""Meshes of USD files: handed to the core as a mesh file that it reads."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt

from ._frangible import BuildError
from .output import missing_packages

#: What USD files end in.
ENDINGS = (".usd", ".usda", ".usdc", ".usdz")

#: Corners of each polygon in order, as indices of vertices.
Polygons = list[npt.NDArray[np.int64]]


@contextmanager
def readable_mesh(path: str | os.PathLike[str]) -> Iterator[str]:
    """The path itself, or for a USD file that of a mesh with all that is to be seen in it, while the context lasts.

    Lengths become metres and y up. `BuildError` if there is no mesh, or no package that reads USD.
    """
    path = os.fspath(path)
    if os.path.splitext(path)[1].lower() not in ENDINGS or not os.path.isfile(path):
        yield path
        return
    if hint := missing_packages("usd"):
        raise BuildError(f"{path}: {hint}")
    vertices, polygons = read_usd(path)
    with tempfile.TemporaryDirectory() as folder:
        name = os.path.join(folder, f"{os.path.basename(path)}.obj")
        _write_obj(name, vertices, polygons)
        try:
            yield name
        except BuildError as error:
            raise BuildError(str(error).replace(name, path)) from None


def read_usd(path: str) -> tuple[npt.NDArray[np.float64], Polygons]:
    """Vertices (v, 3) [m] and polygons of all meshes that are visible and no guides, at the first time of the file."""
    from pxr import Tf, Usd, UsdGeom

    # Open it, and find its units.
    try:
        stage = Usd.Stage.Open(path)
    except Tf.ErrorException as error:
        raise BuildError(f"{path}: is not a readable USD file") from error
    time = Usd.TimeCode(stage.GetStartTimeCode()) if stage.HasAuthoredTimeCodeRange() else Usd.TimeCode.EarliestTime()
    file_units = np.diag([UsdGeom.GetStageMetersPerUnit(stage)] * 3)
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        # x stays, z goes up, y comes from the back.
        file_units = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]) @ file_units
    transforms = UsdGeom.XformCache(time)

    # Each mesh with the transforms above it.
    vertices: list[npt.NDArray[np.float64]] = []
    polygons: Polygons = []
    count = 0
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if not prim.IsA(UsdGeom.Mesh) or not _is_seen(UsdGeom.Mesh(prim), time):
            continue
        mesh = UsdGeom.Mesh(prim)
        points = _array(mesh.GetPointsAttr(), time, np.float64).reshape(-1, 3)
        counts = _array(mesh.GetFaceVertexCountsAttr(), time, np.int64)
        corners = _array(mesh.GetFaceVertexIndicesAttr(), time, np.int64)
        if len(corners) != counts.sum() or np.any((corners < 0) | (corners >= len(points))):
            raise BuildError(f"{path}: the faces of {prim.GetPath()} do not fit its points")

        # USD multiplies rows; what turns the inside out turns the polygons, too.
        matrix = np.array(transforms.GetLocalToWorldTransform(prim), np.float64)
        linear = file_units @ matrix[:3, :3].T
        # What is not finite the core refuses.
        with np.errstate(invalid="ignore"):
            vertices.append(points @ linear.T + file_units @ matrix[3, :3])
        is_left_handed = mesh.GetOrientationAttr().Get(time) == UsdGeom.Tokens.leftHanded
        is_turned = is_left_handed != bool(np.linalg.det(linear) < 0.0)
        faces = np.split(corners + count, np.cumsum(counts)[:-1]) if len(counts) else []
        polygons.extend(face[::-1] if is_turned else face for face in faces)
        count += len(points)
    if not polygons:
        raise BuildError(f"{path}: has no mesh that can be seen")
    return np.concatenate(vertices), polygons


def _array(attribute: Any, time: Any, dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    value = attribute.Get(time)
    return np.array([] if value is None else value, dtype)


def _is_seen(mesh: Any, time: Any) -> bool:
    from pxr import UsdGeom

    is_visible = mesh.ComputeVisibility(time) != UsdGeom.Tokens.invisible
    return is_visible and mesh.ComputePurpose() in (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)


def _write_obj(path: str, vertices: npt.NDArray[np.float64], polygons: Polygons) -> None:
    with open(path, "w", encoding="ascii") as file:
        file.writelines(f"v {x!r} {y!r} {z!r}\n" for x, y, z in vertices.tolist())
        file.writelines(f"f {' '.join(str(corner + 1) for corner in face)}\n" for face in polygons)
