"""The subject of a shot: main bodies in the picture in all frames, and as large as they can be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from frangible import Recording, run
from frangible.recording import Body, rotation_matrix
from frangible.render.camera import Camera, frame_recording
from frangible.render.stage import build_stage, gather_surfaces
from frangible.render.tracing import trace
from support import ASPECT, box, on_picture, shot

FRAMES = 60
SCALES = [1e-4, 1.0, 1e3]


def rest(place: list[float]) -> np.ndarray:
    return np.tile(np.array(place, float), (FRAMES + 1, 1))


def fall(place: list[float], half: float) -> np.ndarray:
    """From a place until it lies on the ground."""
    path = rest(place)
    path[:, 1] = np.maximum(place[1] - 0.5 * 9.81 * (np.arange(FRAMES + 1) / 24.0) ** 2, half)
    return path


def floor() -> Body:
    return box(1, rest([0, -1, 0]), [500, 2, 500], mass=np.inf)


def groups(first: int, second: int, apart: float) -> list[Body]:
    left = [box(2 + i, rest([1.2 * i, 0.5, 0]), [1, 1, 1]) for i in range(first)]
    right = [
        box(2 + first + i, fall([apart + 1.2 * i, 3, 0], 0.5), [1, 1, 1]) for i in range(second)
    ]
    return left + right


def slide() -> Body:
    path = rest([0, 0.05, 0])
    path[:, 0] = 2.2 * np.minimum(np.arange(FRAMES + 1) / 40.0, 1.0) ** 0.5
    return box(2, path, [0.1, 0.1, 0.1])


#: Bodies on a floor.
SCENES: dict[str, list[Body]] = {
    "one falls from 20 m": [box(2, fall([0, 20.5, 0], 0.5), [1, 1, 1])],
    "a small one falls from 20 m": [box(2, fall([0, 20, 0], 0.05), [0.1, 0.1, 0.1])],
    "two groups far apart": groups(3, 3, 40.0),
    "two unequal groups far apart": groups(3, 2, 40.0),
    "a long row": [box(2 + i, rest([0.5 * i, 0.5, 0]), [0.2, 1, 0.6]) for i in range(80)],
    "a row away from the camera": [box(2 + i, rest([0, 0.5, i]), [0.5, 1, 0.5]) for i in range(40)],
    "a tall tower": [box(2 + i, rest([0, 0.5 + i, 0]), [1, 1, 1]) for i in range(100)],
    "a pyramid": [
        box(2 + 20 * y + x, rest([x + y / 2, y + 0.5, 0]), [0.9, 1, 1])
        for y in range(12)
        for x in range(12 - y)
    ],
    "a tiny one": [box(2, rest([30, 0.005, 20]), [0.01, 0.01, 0.01])],
    "a way of 20 times its size": [slide()],
}


def scaled(bodies: list[Body], scale: float) -> Recording:
    grown = [
        replace(body, vertices=body.vertices * np.float32(scale), positions=body.positions * scale)
        for body in bodies
    ]
    return shot(grown, FRAMES)


def corners(body: Body, frame: int) -> np.ndarray:
    """(8, 3) of its box, world frame."""
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    choice = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    position, orientation = body.pose(frame)
    return np.where(choice, high, low) @ rotation_matrix(orientation).T + position


def is_seen(camera: Camera, body: Body, frame: int) -> bool:
    local = (corners(body, frame) - camera.eye) @ camera.axes.T
    half = local[:, 2:] * camera.half_height * [ASPECT, 1.0]
    return bool(np.all(local[:, 2] > 0.0) and np.all(np.abs(local[:, :2]) <= half))


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("name", SCENES)
def test_all_bodies_are_seen_in_all_frames_and_their_way_fills_the_picture(
    name: str, scale: float
) -> None:
    recording = scaled([floor(), *SCENES[name]], scale)
    camera = frame_recording(recording, ASPECT)
    moving = [body for body in recording.bodies if np.isfinite(body.mass)]
    for body in moving:
        assert is_seen(camera, body, 0)
        assert not np.ptp(body.positions, axis=0).any() or all(
            is_seen(camera, body, frame) for frame in range(FRAMES + 1)
        )
    ways = [on_picture(camera, corners(body, frame)) for body in moving for frame in (0, FRAMES)]
    assert np.ptp(np.concatenate(ways), axis=0).max() > 2.0 * 0.85


def test_a_wall_far_away_changes_nothing_and_one_nearby_is_seen_whole() -> None:
    bodies = [floor(), *SCENES["one falls from 20 m"]]
    alone = frame_recording(shot(bodies, FRAMES), ASPECT)
    far = box(9, rest([0, 30, -300]), [400, 60, 1], mass=np.inf)
    with_far = frame_recording(shot([*bodies, far], FRAMES), ASPECT)
    assert np.allclose(alone.eye, with_far.eye)
    near = box(9, rest([0, 5, -3]), [10, 10, 1], mass=np.inf)
    assert is_seen(frame_recording(shot([*bodies, near], FRAMES), ASPECT), near, 0)


def test_what_comes_from_far_away_does_not_make_a_stack_small() -> None:
    stack = [box(2 + i, rest([0, 0.5 + i, 0]), [1, 1, 1]) for i in range(5)]
    way = rest([1.5, 0.5, 0])
    way[:, 0] += np.linspace(100.0, 0.0, FRAMES + 1)
    alone = frame_recording(shot([floor(), *stack], FRAMES), ASPECT)
    struck = frame_recording(shot([floor(), *stack, box(8, way, [1, 1, 1])], FRAMES), ASPECT)
    assert np.allclose(alone.eye, struck.eye)


def test_three_quarters_of_what_breaks_are_seen_by_mass_and_the_rest_may_fly_off() -> None:
    pieces = []
    for number, mass in enumerate([5.0, 3.0, 1.0, 0.5, 0.5]):
        path = rest([0.4 * number, 0.5, 0])[10:]
        if mass <= 1.0:
            path[:, 0] += 0.4 * np.arange(FRAMES - 9)
        pieces.append(box(3 + number, path, [0.4, 1, 0.5], born=10, parent=2, mass=mass))
    whole = box(2, rest([0.8, 0.5, 0])[:10], [2, 1, 0.5], died=10, mass=10.0)
    camera = frame_recording(shot([floor(), whole, *pieces], FRAMES), ASPECT)
    assert is_seen(camera, whole, 0)
    # The first two weigh 8 tenths of it.
    assert all(is_seen(camera, piece, FRAMES) for piece in pieces[:2])
    assert not is_seen(camera, pieces[4], FRAMES)
    alone = frame_recording(shot([floor(), whole, *pieces[:2]], FRAMES), ASPECT)
    assert np.allclose(camera.eye, alone.eye)


def test_what_goes_farther_than_it_can_be_seen_is_seen_at_first() -> None:
    way = rest([-8, 1.5, 0])
    way[:, 0] = np.where(np.arange(FRAMES + 1) < 3, -8 + 3 * np.arange(FRAMES + 1), 0.0)
    way[3:, 0] = -1.4 * np.arange(FRAMES - 2)
    plate = box(2, way, [0.3, 0.3, 0.3])
    wall = box(3, rest([0, 1.5, 0]), [0.01, 3, 3], mass=np.inf)
    camera = frame_recording(shot([floor(), plate, wall], FRAMES), ASPECT)
    assert all(is_seen(camera, plate, frame) for frame in range(4))
    assert is_seen(camera, wall, 0)
    assert np.ptp(on_picture(camera, corners(plate, 0)), axis=0).max() > 2.0 * 0.05


#: Shots with the least shares that are seen of the bodies that move or break, by their sizes: at
#: first, and at any frame; and how much of the picture's width or height they span at first.
SHOTS = {
    "wall": (1.0, 0.45, 0.6),
    "wall-ball": (1.0, 0.8, 0.6),
    "cylinder": (1.0, 0.3, 0.5),
    "pillar": (1.0, 0.9, 0.6),
    "stack": (0.7, 0.7, 0.58),
    "plate": (1.0, 0.0, 0.1),
    "incline": (1.0, 1.0, 0.07),
    "cradle": (1.0, 1.0, 0.5),
    "timber": (0.8, 0.8, 0.5),
    "plank": (0.85, 0.1, 0.2),
    "rain-25": (0.9, 0.8, 0.7),
}


@pytest.mark.parametrize("name", SHOTS)
def test_shots_are_framed_well(name: str) -> None:
    recording = run(name)
    camera = frame_recording(recording, ASPECT)
    solid = [body for body in recording.bodies if len(body.vertices)]
    broken = {body.source for body in solid if body.parent is not None}
    acting = [body for body in solid if np.isfinite(body.mass) or body.source in broken]
    shares = []
    for frame in np.linspace(0, recording.frames, 6).round().astype(int).tolist():
        alive = [body for body in acting if body.alive(frame)]
        sizes = np.array([np.linalg.norm(np.ptp(body.vertices, axis=0)) for body in alive])
        seen = np.array([is_seen(camera, body, frame) for body in alive])
        shares.append(float(sizes @ seen / sizes.sum()))
    at_first, at_least, span = SHOTS[name]
    assert shares[0] >= at_first - 1e-6
    assert min(shares) >= at_least - 1e-6
    shown = [
        on_picture(camera, corners(body, 0))
        for body in acting
        if body.alive(0) and is_seen(camera, body, 0)
    ]
    assert np.ptp(np.concatenate(shown), axis=0).max() >= 2.0 * span


#: Shots with a frame, what is looked at, and how much of the picture it covers at least.
COVERS = {
    "wall-ball": (12, "ball", 0.01),
    "incline": (150, "cube", 0.012),
    "refracture": (26, "wall", 0.17),
    "cylinder": (14, "cylinder", 0.13),
    "cradle": (20, "", 0.02),
    "rain-25": (50, "", 0.12),
}


def share_of_picture(recording: Recording, frame: int, name: str) -> float:
    """The share that bodies cover which move or break, and whose names begin so."""
    camera = frame_recording(recording, ASPECT)
    surfaces = gather_surfaces(recording, frame)
    stage = build_stage(recording, surfaces, frame, camera)
    width, height = 96, 54
    y, x = np.divmod(np.arange(width * height), width)
    directions = camera.rays(x + 0.5, y + 0.5, width, height).astype(np.float32)
    origin = (camera.eye - camera.target).astype(np.float32)
    hits = trace(stage, np.tile(origin, (len(directions), 1)), directions)
    shown = stage.body[hits.triangle]
    seen = [
        index
        for index, body in enumerate(surfaces.bodies)
        if body.moves and body.name.startswith(name)
    ]
    return float(np.isin(shown, seen).sum() / (width * height))


@pytest.mark.parametrize("name", COVERS)
def test_what_happens_is_seen_and_near(name: str) -> None:
    frame, whose, least = COVERS[name]
    assert share_of_picture(run(name), frame, whose) >= least


@pytest.mark.parametrize("towards", [1.0, -1.0])
def test_the_camera_stands_where_what_breaks_is_not_hidden(towards: float) -> None:
    """A ball breaks on a wall, which it pushes a little away."""
    wall = rest([0, 2, 0])
    wall[10:, 2] -= towards * 0.2
    ball = rest([0, 2, 0])[:10]
    ball[:, 2] = towards * np.linspace(4.0, 0.6, 10)
    pieces = []
    for number in range(4):
        path = rest([0.2 * number - 0.3, 2, towards * 0.5])[10:]
        fallen = 0.5 * 9.81 * (np.arange(FRAMES - 9) / 30.0) ** 2
        path[:, 1] = np.maximum(2.0 - fallen, 0.2)
        pieces.append(box(4 + number, path, [0.3, 0.3, 0.3], born=10, parent=3))
    bodies = [box(2, wall, [6, 4, 0.3], mass=1000.0)]
    bodies += [box(3, ball, [0.6, 0.6, 0.6], died=10, mass=4.0), *pieces]
    camera = frame_recording(shot([floor(), *bodies], FRAMES), ASPECT)
    assert camera.eye[2] * towards > 0.0


def test_the_camera_stands_where_bricks_fly_out_of_a_wall_that_stands() -> None:
    wall = box(2, rest([0, 1, 0])[:5], [3, 2, 0.2], died=5, mass=np.inf)
    left = box(3, rest([0, 1, 0])[5:], [3, 2, 0.2], born=5, parent=2, mass=np.inf)
    ball = rest([0.2, 1, 0])
    ball[:, 2] = 0.4 * (5 - np.arange(FRAMES + 1))
    bricks = []
    for number in range(6):
        path = rest([0.25 * number - 0.5, 1, 0])[5:]
        path[:, 2] -= 0.15 * np.minimum(np.arange(FRAMES - 4), 12)
        path[12:, 1] = 0.1
        bricks.append(box(5 + number, path, [0.2, 0.1, 0.1], born=5, parent=2))
    striker = box(4, ball, [0.3, 0.3, 0.3], mass=200.0)
    camera = frame_recording(shot([floor(), wall, left, striker, *bricks], FRAMES), ASPECT)
    assert camera.eye[2] < 0.0
    # The wall fills the picture though the ball goes on.
    assert np.ptp(on_picture(camera, corners(left, 10)), axis=0).max() > 2.0 * 0.6


def test_fragments_that_never_move_are_all_seen() -> None:
    cells = [
        box(2 + 4 * y + x, rest([1.2 * x, 1.2 * y + 0.5, 0]), [1, 1, 1], parent=1)
        for y in range(4)
        for x in range(4)
    ]
    camera = frame_recording(shot(cells, 0), ASPECT)
    assert all(is_seen(camera, cell, 0) for cell in cells)


def test_glass_hides_nothing() -> None:
    bodies = [floor(), *SCENES["one falls from 20 m"]]
    screens = [
        box(10 + i, rest([x, 12, z]), [0.2 + 30 * (z != 0), 24, 0.2 + 30 * (x != 0)], mass=np.inf)
        for i, (x, z) in enumerate([(-9, 0), (9, 0), (0, -9), (0, 9)])
    ]
    glass = [replace(screen, look="glass") for screen in screens]
    behind = frame_recording(shot([*bodies, *screens], FRAMES), ASPECT)
    through = frame_recording(shot([*bodies, *glass], FRAMES), ASPECT)
    assert -behind.axes[2][1] > 0.7
    assert -through.axes[2][1] < 0.5


def test_into_a_pit_the_camera_looks_from_above() -> None:
    walls = [
        box(10 + i, rest([x, 3, z]), [0.3 + 6 * abs(z) / 3, 6, 0.3 + 6 * abs(x) / 3], mass=np.inf)
        for i, (x, z) in enumerate([(-3, 0), (3, 0), (0, -3), (0, 3)])
    ]
    loose = [box(2 + i, rest([i - 2, 0.5, 0]), [0.8, 1, 1]) for i in range(4)]
    camera = frame_recording(shot([floor(), *walls, *loose], FRAMES), ASPECT)
    ahead = camera.axes[2]
    assert -ahead[1] > np.hypot(ahead[0], ahead[2])
    without = frame_recording(shot([floor(), *loose], FRAMES), ASPECT)
    assert -without.axes[2][1] < 0.5
