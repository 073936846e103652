"""One camera for a whole shot: where it stands, and files that describe one."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from frangible import Recording
from frangible.render.camera import CameraError, camera_for, frame_recording, read_camera
from support import ASPECT, box, on_picture, shot


def wall_and_ball(towards: float, scale: float = 1.0) -> Recording:
    """A wall breaks in two at frame 10; a ball goes on through it for 90 frames."""
    along = np.arange(101) - 10.0
    ball = np.stack([np.zeros(101), np.ones(101), towards * along], axis=1)
    piece = np.stack([np.zeros(91), np.ones(91), towards * 0.01 * np.arange(91)], axis=1)
    bodies = [
        box(1, [[0, 1, 0]] * 10, [3, 2, 0.3], died=10, mass=1000.0),
        box(2, ball, [0.3, 0.3, 0.3], mass=np.inf),
        box(3, piece + [-0.75, 0, 0], [1.5, 2, 0.3], born=10, parent=1, mass=500.0),
        box(4, piece + [0.75, 0, 0], [1.5, 2, 0.3], born=10, parent=1, mass=500.0),
    ]
    scaled = [
        replace(body, vertices=body.vertices * np.float32(scale), positions=body.positions * scale)
        for body in bodies
    ]
    return shot(scaled, 100)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_what_breaks_fills_the_picture_and_a_ball_that_flies_on_does_not(scale: float) -> None:
    recording = wall_and_ball(1.0, scale)
    places = on_picture(frame_recording(recording, ASPECT), recording.bodies[0].vertices_world(0))
    assert np.all(np.abs(places) <= 1.0)
    assert np.max(np.ptp(places, axis=0)) > 1.0


@pytest.mark.parametrize("towards", [1.0, -1.0])
def test_the_camera_stands_where_the_pieces_go(towards: float) -> None:
    assert frame_recording(wall_and_ball(towards), ASPECT).eye[2] * towards > 0.0


def test_a_piece_that_flies_off_does_not_make_the_rest_a_dot() -> None:
    recording = wall_and_ball(1.0)
    stray = box(5, [[0.0, 1.0, float(i)] for i in range(91)], [0.1] * 3, born=10, parent=1)
    near = frame_recording(recording, ASPECT)
    with_stray = frame_recording(replace(recording, bodies=[*recording.bodies, stray]), ASPECT)
    distances = [float(np.linalg.norm(one.eye - [0, 1, 0])) for one in (near, with_stray)]
    assert distances[1] < 1.5 * distances[0]


def test_without_a_break_the_camera_sees_the_whole_way_of_what_moves() -> None:
    way = np.stack([np.linspace(0.0, 4.0, 61), np.zeros(61), np.zeros(61)], axis=1)
    floor = box(1, [[0, -1, 0]] * 61, [100, 1, 100], mass=np.inf)
    recording = shot([floor, box(2, way, [0.2, 0.2, 0.2])], 60)
    camera = frame_recording(recording, ASPECT)
    for frame in (0, 30, 60):
        assert np.all(np.abs(on_picture(camera, recording.body(2).vertices_world(frame))) <= 1.0)


def test_a_wall_in_between_sends_the_camera_to_another_side() -> None:
    recording = wall_and_ball(1.0)
    before = frame_recording(recording, ASPECT)
    assert before.eye[2] > 0.0
    screen = box(6, [[0, 2, 2.0]] * 101, [12, 8, 0.2], mass=np.inf)
    behind = frame_recording(replace(recording, bodies=[*recording.bodies, screen]), ASPECT)
    assert behind.eye[2] < 0.0


def test_of_nothing_there_is_a_picture_too() -> None:
    camera = frame_recording(shot([], 3), ASPECT)
    assert np.all(np.isfinite(camera.eye))


def test_fragments_without_the_body_that_they_were_are_framed_too() -> None:
    pieces = [body for body in wall_and_ball(1.0).bodies if body.parent is not None]
    camera = frame_recording(shot(pieces, 100), ASPECT)
    assert np.all(np.abs(on_picture(camera, pieces[0].vertices_world(10))) <= 1.0)


def test_a_file_says_where_the_camera_stands(tmp_path: Path, scripted: Recording) -> None:
    path = tmp_path / "camera.json"
    path.write_text(json.dumps({"eye": [1, 2, 6], "target": [1, 2, 0], "fov": 90}))
    camera = camera_for(scripted, str(path), ASPECT)
    assert camera.eye.tolist() == [1.0, 2.0, 6.0]
    assert camera.axes == pytest.approx(np.array([[1, 0, 0], [0, 1, 0], [0, 0, -1]]))
    assert camera.half_height == pytest.approx(1.0)
    assert camera.fov == pytest.approx(90.0)


@pytest.mark.parametrize(
    ("text", "rule"),
    [
        ("{", "is not a readable JSON file"),
        ("[1]", "must hold one JSON object"),
        ('{"eye": [0, 0, 1]}', "has no field 'target'"),
        ('{"eye": [0, 1], "target": [0, 0, 0]}', "eye: [0, 1], must be three finite numbers"),
        ('{"eye": [0, 0, NaN], "target": [0, 0, 0]}', "must be three finite numbers"),
        ('{"eye": [0, 0, 0], "target": [0, 0, 0]}', "must differ from target"),
        ('{"eye": [0, 0, 1], "target": [0, 0, 0], "up": [0, 0, 2]}', "must not be 0, nor point"),
        ('{"eye": [0, 0, 1], "target": [0, 0, 0], "fov": 180}', "fov: 180, must be > 0 and < 180"),
        ('{"eye": [0, 0, 1], "target": [0, 0, 0], "fov": "wide"}', "must be a number of degrees"),
        ('{"eye": [0, 0, 1], "target": [0, 0, 0], "zoom": 2}', "field 'zoom' is unknown"),
        (" " * 70_000, "must hold one JSON object"),
    ],
)
def test_a_wrong_file_is_one_sentence(text: str, rule: str, tmp_path: Path) -> None:
    path = tmp_path / "camera.json"
    path.write_text(text)
    with pytest.raises(CameraError) as caught:
        read_camera(str(path))
    assert str(caught.value).startswith(f"{path}: ")
    assert rule in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_named() -> None:
    with pytest.raises(CameraError, match="nowhere.json: no such file"):
        read_camera("nowhere.json")
