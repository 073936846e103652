"""Alembic: a rigid transform for every body, and a mesh below it that is written once."""

from __future__ import annotations

from typing import Any

import imath
import numpy as np
import numpy.typing as npt
from alembic3d import Abc, AbcCoreAbstract, AbcGeom

from ..names import by_source, unique_names
from ..recording import Body, Recording, rotation_matrix
from ..render.ground import with_visible_ground
from ..render.normals import corner_normals, shaded_mesh
from ..render.palette import Palette


def write_abc(recording: Recording, path: str) -> None:
    """Write ``.abc``, in metres, y up; frame N is at N frames of the recording's rate.

    A body that is not there has a scale of 0.
    """
    archive = Abc.OArchive(path)
    sampling = AbcCoreAbstract.TimeSampling(1.0 / recording.fps, 0.0)
    number = archive.addTimeSampling(sampling)
    families = by_source(with_visible_ground(recording).bodies)
    # Face sets have the names of materials.
    palette: Palette[str] = Palette(families, lambda name, _: name)
    top = archive.getTop()
    sources = unique_names(family[0].name for family in families.values())
    for source, family in zip(sources, families.values(), strict=True):
        above = AbcGeom.OXform(top, source)
        names = unique_names(body.name for body in family)
        for name, body in zip(names, family, strict=True):
            xform = AbcGeom.OXform(above, name, number)
            _move(xform.getSchema(), body, recording.frames)
            _mesh(AbcGeom.OPolyMesh(xform, f"{name}_shape"), body, palette)


def _move(schema: Any, body: Body, frames: int) -> None:
    """A matrix for each frame; one for all of a body that stays."""
    rests = not np.any(body.positions != body.positions[0]) and not np.any(
        body.orientations != body.orientations[0]
    )
    if rests and body.birth_frame == 0 and body.death_frame is None:
        schema.set(_sample(body, 0))
        return
    for frame in range(frames + 1):
        schema.set(_sample(body, frame))


def _sample(body: Body, frame: int) -> Any:
    """Where the body is; at its first or last place, without a size, while it is not there."""
    is_there = body.alive(frame)
    row = min(max(frame - body.birth_frame, 0), len(body.positions) - 1)
    rows = np.zeros((4, 4))
    rows[:3, :3] = rotation_matrix(body.orientations[row]).T * float(is_there)
    rows[3] = [*body.positions[row], 1.0]
    sample = AbcGeom.XformSample()
    sample.setMatrix(imath.M44d(*rows.ravel().tolist()))
    return sample


def _mesh(mesh: Any, body: Body, palette: Palette[str]) -> None:
    # Alembic's faces turn the other way.
    triangles = body.triangles[:, ::-1].astype(np.int32)
    shaded = shaded_mesh(body.vertices, body.triangles, body.interior)
    normals = corner_normals(body, shaded)[:, ::-1].reshape(-1, 3)
    coordinates = body.coordinates[:, ::-1].reshape(-1, 2)
    schema = mesh.getSchema()
    sample = AbcGeom.OPolyMeshSchemaSample(
        _array(imath.V3fArrayFromBuffer, body.vertices),
        _integers(triangles.ravel()),
        _integers(np.full(len(triangles), 3)),
        AbcGeom.OV2fGeomParamSample(
            _array(imath.V2fArrayFromBuffer, coordinates),
            AbcGeom.GeometryScope.kFacevaryingScope,
        ),
        AbcGeom.ON3fGeomParamSample(
            _array(imath.V3fArrayFromBuffer, normals), AbcGeom.GeometryScope.kFacevaryingScope
        ),
    )
    schema.set(sample)
    for name, faces, _ in palette.groups(body):
        if faces.any():
            group = schema.createFaceSet(name).getSchema()
            group.set(AbcGeom.OFaceSetSchemaSample(_integers(np.flatnonzero(faces))))


def _array(make: Any, values: npt.NDArray[Any]) -> Any:
    return make(np.ascontiguousarray(values, np.float32))


def _integers(values: npt.NDArray[Any]) -> Any:
    return imath.IntArrayFromBuffer(np.ascontiguousarray(values, np.int32))
