"""The first touch of a ball and a mesh, by closed forms, by distance, and in the engine."""

from pathlib import Path

import numpy as np
import pytest
from frangible import BuildError, World
from frangible.first_touch import first_touch
from frangible.mesh_scene import Wishes, mesh_scene
from test_artists_day import vase

#: A tetrahedron with a right angle in the origin.
POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float64)
TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def touch(through: list[float], direction: list[float], radius: float = 0.1) -> float | None:
    unit = np.array(direction, np.float64) / np.linalg.norm(direction)
    return first_touch(POINTS, TRIANGLES, np.array(through, np.float64), unit, radius)


def test_faces_edges_and_vertices() -> None:
    # The face in z = 0, from below, however steep; its middle from the other side is not met first.
    assert touch([0.2, 0.2, 0], [0, 0, 1]) == pytest.approx(-0.1)
    assert touch([0.2, 0.2, 0], [1, 0, 1]) == pytest.approx(-0.1 * np.sqrt(2))
    # The slanted face, straight on.
    assert touch([0.2, 0.2, 0.2], [-1, -1, -1]) == pytest.approx(-0.1 - 0.4 / np.sqrt(3))
    # The edge along x, aside by 6 cm; and one of its ends, aside by 6 cm along x.
    assert touch([0.5, -0.06, 0], [0, 0, 1]) == pytest.approx(-0.08)
    assert touch([1.06, 0, 0], [0, 0, 1]) == pytest.approx(-0.08)
    # Past it.
    assert touch([0.5, -0.101, 0], [0, 0, 1]) is None
    assert touch([0.5, -0.099, 0], [0, 0, 1]) is not None


def distance(points: np.ndarray, triangles: np.ndarray, at: np.ndarray) -> float:
    """By many points of each triangle."""
    steps = np.linspace(0, 1, 40)
    u, v = (grid.ravel() for grid in np.meshgrid(steps, steps))
    inside = u + v <= 1.0 + 1e-12
    u, v = u[inside], v[inside]
    a, b, c = (points[triangles[:, k]][:, None] for k in range(3))
    samples = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    return float(np.linalg.norm(samples - at, axis=-1).min())


def test_random_balls_are_at_their_radius_from_the_mesh() -> None:
    random = np.random.default_rng(3)
    hits = 0
    for _ in range(60):
        through, direction = random.uniform(-0.3, 1, 3), random.normal(size=3)
        direction /= np.linalg.norm(direction)
        radius = random.uniform(0.05, 0.5)
        place = first_touch(POINTS, TRIANGLES, through, direction, radius)
        along = np.linspace(-4, 4, 161) if place is None else place - np.linspace(0, 3, 61)[1:]
        nearest = min(distance(POINTS, TRIANGLES, through + s * direction) for s in along)
        if place is None:
            assert nearest > radius - 1e-6
            continue
        hits += 1
        at = distance(POINTS, TRIANGLES, through + place * direction)
        assert at == pytest.approx(radius, abs=5e-3)
        assert nearest >= radius - 1e-9
    assert 30 < hits < 60


@pytest.mark.parametrize("frame", [3, 20, 60])
@pytest.mark.parametrize("speed", [6.0, 15.0])
@pytest.mark.parametrize("radius", [2.0, 25.0])
@pytest.mark.parametrize("origin", [(0, -300, 30), (-100, 100, 150), (200, 50, 24)])
def test_the_engine_agrees_on_the_frame(
    frame: int, speed: float, radius: float, origin: tuple[float, float, float], tmp_path: Path
) -> None:
    """The vase, which waits in the air, is struck in the frame that was wished."""
    path = tmp_path / "vase.obj"
    path.write_text(vase())
    wishes = Wishes(
        ball=(radius, speed), origin=origin, hit_at_frame=frame, up="z", unit="cm",
        frames_per_second=24,
    )  # fmt: skip
    scene = mesh_scene(path, wishes).to_dict()
    # It need not break for this.
    scene["bodies"][0]["breaking"] = {"strength": 1e9}
    scene["bodies"][0]["shape"]["resolution"] = {"voxels": [24, 24, 24]}
    world = World.build(scene, 1)
    for number in range(1, frame + 1):
        waiting = world.step()["waiting"]
        assert waiting == (number < frame), number


def test_a_ball_through_a_hole_is_refused(tmp_path: Path) -> None:
    ring = []
    profile = ((0.8, -0.1), (1, -0.1), (1, 0.1), (0.8, 0.1))
    for turn in range(24):
        angle = 2 * np.pi * turn / 24
        x, z = np.cos(angle), np.sin(angle)
        ring += [f"v {r * x} {y} {r * z}" for r, y in profile]
    for turn in range(24):
        here, there = 4 * turn, 4 * ((turn + 1) % 24)
        for k in range(4):
            j = (k + 1) % 4
            ring.append(f"f {here + k + 1} {here + j + 1} {there + j + 1} {there + k + 1}")
    path = tmp_path / "ring.obj"
    path.write_text("\n".join(ring) + "\n")
    with pytest.raises(BuildError, match="through a hole in it"):
        mesh_scene(path, Wishes(ball=(0.1, 9.0), origin=(0, 3, 0)))
    assert mesh_scene(path, Wishes(ball=(0.1, 9.0), origin=(3, 0, 0))).bodies
