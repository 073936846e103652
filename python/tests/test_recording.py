"""Recordings: lives, families, motion and the cache."""

from pathlib import Path

import numpy as np
import pytest
from frangible import CacheError, Recording
from frangible.io.keyframes import telling_samples
from frangible.names import unique_names
from frangible.recording import rotation_matrix
from frangible.render.normals import shaded_mesh
from support import CUBE_TRIANGLES, CUBE_VERTICES


def test_lives_span_the_frames_that_show_a_body(scripted: Recording) -> None:
    lives = {body.id: (body.birth_frame, body.death_frame) for body in scripted.bodies}
    assert lives == {0: (0, None), 1: (0, 3), 2: (3, None), 4: (3, None), 5: (3, None)}
    assert [body.id for body in scripted.alive(2)] == [0, 1]
    assert [body.id for body in scripted.alive(3)] == [0, 2, 4, 5]
    assert all(
        len(body.positions) == (body.death_frame or scripted.frames + 1) - body.birth_frame
        for body in scripted.bodies
    )


def test_fragments_find_their_source_past_bodies_that_no_frame_showed(scripted: Recording) -> None:
    assert {body.id: (body.parent, body.source) for body in scripted.bodies} == {
        0: (None, 0),
        1: (None, 1),
        2: (1, 1),
        4: (3, 1),
        5: (3, 1),
    }


def test_quaternions_never_flip_sign_between_frames(scripted: Recording) -> None:
    orientations = scripted.body(2).orientations
    assert np.all(np.sum(orientations[1:] * orientations[:-1], axis=1) > 0.0)


def test_world_vertices_follow_the_pose(scripted: Recording) -> None:
    # At frame 5 body 2 has turned by five quarters about y, which takes -z to -x and -x to z.
    body = scripted.body(2)
    assert body.vertices[0].tolist() == [-0.5, -0.5, -0.5]
    assert body.vertices_world(5)[0] == pytest.approx([-0.5 - 0.5, 1.5 - 0.5, 0.5])


def test_fragments_know_where_they_were_in_what_broke(wall: Recording, scripted: Recording) -> None:
    # A parent that no frame showed was a part of the slab at y = 3.
    for body, across in ((2, -0.5), (4, 0.25), (5, 0.75)):
        assert scripted.body(body).before == pytest.approx([across, 3.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    assert scripted.body(1).before is None

    (slab,) = (body for body in wall.bodies if body.name == "wall")
    pieces = [body for body in wall.bodies if body.parent == slab.id]
    assert len(pieces) > 10
    position, orientation = slab.pose(pieces[0].birth_frame - 1)
    low, high = slab.vertices.min(axis=0), slab.vertices.max(axis=0)
    total = np.zeros(3)
    for piece in pieces:
        assert piece.before is not None
        world = piece.vertices @ rotation_matrix(piece.before[3:]).T + piece.before[:3]
        inside = (world - position) @ rotation_matrix(orientation)
        assert np.all(inside >= low - 1e-6) and np.all(inside <= high + 1e-6)
        total += piece.mass * (piece.before[:3] - position)
    # Together they are where it was.
    assert np.abs(total).max() <= 1e-9 * slab.mass


def test_a_cache_reads_back_as_the_same_recording(scripted: Recording, tmp_path: Path) -> None:
    path = tmp_path / "slab.npz"
    scripted.save(path)
    loaded = Recording.load(path)
    assert (loaded.shot, loaded.method, loaded.fps, loaded.frames) == ("slab", "paper", 24.0, 6)
    assert loaded.reports == scripted.reports
    assert len(loaded.bodies) == len(scripted.bodies)
    for ours, theirs in zip(scripted.bodies, loaded.bodies, strict=True):
        for field in ours.__slots__:
            expected, actual = getattr(ours, field), getattr(theirs, field)
            assert np.array_equal(expected, actual), field
            assert getattr(expected, "dtype", None) == getattr(actual, "dtype", None), field


def test_recordings_and_bodies_print_in_a_line(scripted: Recording) -> None:
    assert repr(scripted) == "<Recording of 'slab', 6 frames at 24 per second, 5 bodies>"
    assert repr(scripted.body(1)) == "<Body 1 'slab', frames 0 to 2, 12 triangles>"
    assert repr(scripted.body(2)) == "<Body 2 'slab.2', frames 3 on, 12 triangles>"


@pytest.mark.parametrize("content", [b"", b"not a zip", b"PK\x05\x06" + bytes(18)])
def test_a_file_that_is_no_cache_says_so(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "bad.npz"
    path.write_bytes(content)
    with pytest.raises(CacheError, match=r"bad\.npz"):
        Recording.load(path)


def test_runs_of_equal_samples_keep_their_ends() -> None:
    values = np.array([1.0, 1, 1, 2, 3, 3, 3, 4, 4])[:, None]
    assert telling_samples(values).tolist() == [0, 2, 3, 4, 6, 7, 8]
    assert telling_samples(np.ones((5, 3))).tolist() == [0]
    assert telling_samples(np.zeros((0, 3))).tolist() == []


def test_names_become_different_identifiers() -> None:
    assert list(unique_names(["wall", "wall", "wall.3", "wall_2", "3", ""])) == [
        "wall", "wall_2", "wall_3", "wall_2_2", "_3", "body",
    ]  # fmt: skip


def test_a_cube_has_sharp_edges_and_a_sphere_does_not() -> None:
    cube = shaded_mesh(CUBE_VERTICES, CUBE_TRIANGLES, np.zeros(12, bool))
    assert len(cube.vertex) == 24
    assert np.allclose(np.abs(cube.normals).max(axis=1), 1.0)

    # A sphere's normals are its radii, and none of its vertices is split.
    vertices, triangles = _sphere(24)
    sphere = shaded_mesh(vertices, triangles, np.zeros(len(triangles), bool))
    assert len(sphere.vertex) == len(vertices)
    assert np.all(np.sum(sphere.normals * vertices[sphere.vertex], axis=1) > 0.99)


def test_a_crack_is_an_edge_even_where_it_is_flat() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    halves = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    assert len(shaded_mesh(square, halves, np.array([False, False])).vertex) == 4
    assert len(shaded_mesh(square, halves, np.array([False, True])).vertex) == 6


def _sphere(rings: int) -> tuple[np.ndarray, np.ndarray]:
    """A unit sphere of rings of latitude, with single vertices at the poles."""
    latitude, longitude = np.meshgrid(
        np.linspace(0, np.pi, rings + 1)[1:-1],
        np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False),
        indexing="ij",
    )
    ring = np.stack(
        [
            np.sin(latitude) * np.cos(longitude),
            np.cos(latitude),
            np.sin(latitude) * np.sin(longitude),
        ],
        -1,
    )
    vertices = np.concatenate([ring.reshape(-1, 3), [[0, 1, 0], [0, -1, 0]]]).astype(np.float32)
    columns, last = 2 * rings, len(vertices) - 2
    triangles = []
    for j in range(columns):
        k = (j + 1) % columns
        triangles += [[last, k, j], [last + 1, last - columns + j, last - columns + k]]
        for i in range(rings - 2):
            a, b, c, d = (
                i * columns + j,
                i * columns + k,
                (i + 1) * columns + j,
                (i + 1) * columns + k,
            )
            triangles += [[a, b, d], [a, d, c]]
    return vertices, np.array(triangles, np.uint32)
