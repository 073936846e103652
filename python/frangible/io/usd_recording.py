"""USD stages whose meshes move, as recordings for the player."""

from __future__ import annotations

import os
import warnings
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom

from ..errors import CacheError, one_sentence
from ..recording import Float64, Recording
from ..skin import NO_MATERIAL, Skin
from .reading import FileNote, file_fault
from .shown_meshes import ShownMesh, fan, recording_of
from .usd_looks import read_usd_materials, stage_material_names
from .usd_poses import is_animated
from .usd_scene import is_physics_stage
from .usd_stage import metres_from_stage, open_stage, written_as

#: Words in the names of materials and subsets that cracks laid bare.
_INSIDE = ("inside", "inner", "interior")
#: The most frames times meshes: some minutes.
_MOST = 20_000_000


def read_usd_recording(path: str) -> Recording | None:
    """The motion of a stage's meshes; `None` if none moves, or if it is a scene with physics."""
    if fault := file_fault(path):
        raise CacheError(f"{path}: {fault}")
    with open_stage(path, CacheError) as stage:
        is_ours = written_as(stage) is not None
        prims = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
        moving = {str(prim.GetPath()) for prim in prims if _changes(prim)}
        if not moving or (not is_ours and is_physics_stage(path)):
            return None
        start, end = stage.GetStartTimeCode(), stage.GetEndTimeCode()
        frames = max(round(end - start), 0)
        if frames * len(moving) > _MOST:
            said = f"{frames} frames of {len(moving)} meshes that move"
            raise CacheError(f"{path}: has {said}, must have at most {_MOST} of both together")
        with one_sentence(path, "USD file", CacheError):
            return _recording(path, stage, prims, moving, frames)


def _recording(
    path: str, stage: Any, prims: list[Any], moving: set[str], frames: int
) -> Recording:
    start = stage.GetStartTimeCode()
    units = np.eye(4)
    units[:3, :3] = metres_from_stage(path, stage)
    names = sorted({name for prim in prims for name in stage_material_names(prim)[0] if name})
    materials = tuple(read_usd_materials(path, names))
    numbers = {name: number for number, name in enumerate(names)}
    # Where each is at each frame, frame by frame: transforms above it are found once.
    matrices = {
        str(prim.GetPath()): np.zeros((frames + 1 if str(prim.GetPath()) in moving else 1, 4, 4))
        for prim in prims
    }
    shown = {name: np.ones(len(rows), np.bool_) for name, rows in matrices.items()}
    cache = UsdGeom.XformCache()
    for frame in range(frames + 1):
        time = Usd.TimeCode(start + frame)
        cache.SetTime(time)
        for prim in prims:
            name = str(prim.GetPath())
            if frame >= len(matrices[name]):
                continue
            visible = UsdGeom.Imageable(prim).ComputeVisibility(time)
            shown[name][frame] = visible != UsdGeom.Tokens.invisible
            matrices[name][frame] = np.array(cache.GetLocalToWorldTransform(prim)).T
    meshes = []
    for prim in prims:
        name = str(prim.GetPath())
        placed = units @ matrices[name]
        found = _mesh(prim, start, placed, shown[name], (materials, numbers))
        if found is not None:
            meshes.append(found)
    shot = os.path.splitext(os.path.basename(path))[0]
    return recording_of(shot, stage.GetTimeCodesPerSecond(), frames, meshes)


def _changes(prim: Any) -> bool:
    """True if a mesh moves, comes or goes."""
    if is_animated(prim):
        return True
    while prim and not prim.IsPseudoRoot():
        if prim.IsA(UsdGeom.Imageable):
            if UsdGeom.Imageable(prim).GetVisibilityAttr().ValueMightBeTimeVarying():
                return True
        prim = prim.GetParent()
    return False


def _mesh(
    prim: Any, start: float, matrices: Float64, is_shown: Any, known: tuple[tuple[Any, ...], Any]
) -> ShownMesh | None:
    mesh = UsdGeom.Mesh(prim)
    time = Usd.TimeCode(start)
    points = mesh.GetPointsAttr().Get(time)
    counts = mesh.GetFaceVertexCountsAttr().Get(time)
    indices = mesh.GetFaceVertexIndicesAttr().Get(time)
    if not points or not counts or not indices:
        return None
    if mesh.GetPointsAttr().ValueMightBeTimeVarying():
        said = "its points move, and are shown where they are at first"
        warnings.warn(f"{prim.GetPath()}: {said}", FileNote, stacklevel=2)
    corners, polygon = fan(np.array(counts, np.int64))
    triangles = np.array(indices, np.int64)[corners]
    if mesh.GetOrientationAttr().Get(time) == UsdGeom.Tokens.leftHanded:
        triangles, corners = triangles[:, ::-1], corners[:, ::-1]
    names, subsets = stage_material_names(prim)
    materials, numbers = known
    of_face = np.array([numbers.get(name, NO_MATERIAL) for name in names], np.int32)
    words = [
        f"{name.rpartition('/')[2]} {subset}".lower()
        for name, subset in zip(names, subsets, strict=True)
    ]
    inside = np.array([any(word in own for word in _INSIDE) for own in words], np.bool_)
    skin = Skin(materials, of_face[polygon], normals=_normals(mesh, time, corners, triangles))
    return ShownMesh(
        prim.GetName(),
        str(prim.GetPath().GetParentPath()),
        np.array(points, np.float64),
        triangles.astype(np.uint32),
        inside[polygon],
        _coordinates(prim, time, corners, triangles),
        skin,
        matrices,
        is_shown,
    )


def _coordinates(prim: Any, time: Any, corners: Any, triangles: Any) -> Any:
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
    values = primvar.ComputeFlattened(time) if primvar and primvar.HasValue() else None
    nothing = np.zeros((len(triangles), 3, 2), np.float32)
    if values is None:
        return nothing
    is_corners = primvar.GetInterpolation() == UsdGeom.Tokens.faceVarying
    index = corners if is_corners else triangles
    rows = np.array(values, np.float32)
    return rows[index] if len(rows) and index.max(initial=0) < len(rows) else nothing


def _normals(mesh: Any, time: Any, corners: Any, triangles: Any) -> Any:
    primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("normals")
    if primvar and primvar.HasValue():
        values, kind = primvar.ComputeFlattened(time), primvar.GetInterpolation()
    else:
        values, kind = mesh.GetNormalsAttr().Get(time), mesh.GetNormalsInterpolation()
    if not values:
        return None
    index = corners if kind == UsdGeom.Tokens.faceVarying else triangles
    rows = np.array(values, np.float32)
    if kind not in (UsdGeom.Tokens.faceVarying, UsdGeom.Tokens.vertex):
        return None
    return rows[index] if index.max(initial=0) < len(rows) else None
