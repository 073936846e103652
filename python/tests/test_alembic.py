"""Alembic caches, read back by the library itself; Blender reads them in test_blender.py."""

from typing import Any

import numpy as np
import pytest
from frangible import Recording

pytest.importorskip("alembic3d")
from alembic3d import Abc, AbcGeom


@pytest.fixture(scope="module")
def archive(scripted: Recording, tmp_path_factory: pytest.TempPathFactory) -> Any:
    path = tmp_path_factory.mktemp("alembic") / "slab.abc"
    scripted.save(path)
    return Abc.IArchive(str(path))


def child(parent: Any, *names: str) -> Any:
    for name in names:
        parent = parent.getChild(name)
    return parent


def test_bodies_are_below_their_sources(archive: Any, scripted: Recording) -> None:
    top = archive.getTop()
    assert [one.getName() for one in top.children] == ["ground", "slab"]
    pieces = [one.getName() for one in child(top, "slab").children]
    assert pieces == ["slab", "slab_2", "slab_4", "slab_5"]


def test_every_frame_is_that_of_the_recording(archive: Any, scripted: Recording) -> None:
    for name, number in (("slab", 1), ("slab_2", 2), ("slab_4", 4), ("slab_5", 5)):
        body = scripted.body(number)
        schema = AbcGeom.IXform(child(archive.getTop(), "slab"), name).getSchema()
        assert schema.getNumSamples() == scripted.frames + 1
        times = schema.getTimeSampling()
        for frame in range(scripted.frames + 1):
            assert times.getSampleTime(frame) == pytest.approx(frame / scripted.fps)
            matrix = schema.getValue(Abc.ISampleSelector(frame / scripted.fps)).getMatrix()
            rows = np.array([[matrix[row][column] for column in range(4)] for row in range(4)])
            if not body.alive(frame):
                assert np.all(rows[:3, :3] == 0.0)
                continue
            placed = body.vertices @ rows[:3, :3] + rows[3, :3]
            assert placed == pytest.approx(body.vertices_world(frame), abs=1e-6)


def test_what_stands_still_has_one_sample(archive: Any) -> None:
    ground = AbcGeom.IXform(child(archive.getTop(), "ground"), "ground").getSchema()
    assert ground.getNumSamples() == 1


def test_cracks_are_a_face_set(archive: Any, scripted: Recording) -> None:
    piece = AbcGeom.IPolyMesh(child(archive.getTop(), "slab", "slab_4"), "slab_4_shape")
    schema = piece.getSchema()
    assert schema.getNumSamples() == 1
    assert sorted(schema.getFaceSetNames()) == ["inside", "slab"]
    faces = schema.getFaceSet("inside").getSchema().getValue().getFaces()
    assert [faces[row] for row in range(len(faces))] == [0, 1, 2, 3]
    sample = schema.getValue()
    index = sample.getFaceIndices()
    # Clockwise, seen from outside.
    assert [index[row] for row in range(3)] == scripted.body(4).triangles[0, ::-1].tolist()
