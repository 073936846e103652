"""Motion blur: poses between frames, and what a shutter sees."""

from dataclasses import replace

import numpy as np
import pytest
from frangible import Recording
from frangible.render.camera import Camera
from frangible.render.picture import picture
from frangible.render.shutter import Shutter, pose_between
from support import box, shot

TURN = np.array([0.0, np.sin(np.pi / 8), 0.0, np.cos(np.pi / 8)])


def test_times_end_at_the_frame_and_fill_the_shutter() -> None:
    assert Shutter(0.0).times(3) == [3.0]
    assert Shutter(180.0, 2).times(3) == [2.875, 2.625]
    assert Shutter(360.0, 4).times(1) == [0.875, 0.625, 0.375, 0.125]


def test_a_body_moves_on_a_line_and_turns_evenly() -> None:
    turns = np.array([[0.0, 0.0, 0.0, 1.0], TURN])
    body = replace(box(1, [[0, 0, 0], [4, 2, 0]], [1, 1, 1]), orientations=turns)
    position, turn = pose_between(body, 0.25)
    assert position == pytest.approx([1.0, 0.5, 0.0])
    # A quarter of 45 degrees.
    assert turn == pytest.approx([0.0, np.sin(np.pi / 32), 0.0, np.cos(np.pi / 32)])
    # The other sign is the same rotation, and as near.
    flipped = replace(body, orientations=turns * [[1.0], [-1.0]])
    assert abs(pose_between(flipped, 0.25)[1] @ turn) == pytest.approx(1.0)
    # Before the first frame it came as it goes on.
    assert pose_between(body, -0.5)[0] == pytest.approx([-2.0, -1.0, 0.0])


def test_a_piece_comes_from_where_its_parent_was(scripted: Recording) -> None:
    piece = scripted.body(4)
    assert piece.before is not None and piece.birth_frame == 3
    half = (piece.before[:3] + piece.positions[0]) / 2.0
    assert pose_between(piece, 2.5)[0] == pytest.approx(half)
    # An older cache does not know: it is there at once.
    alone = replace(piece, before=None)
    assert pose_between(alone, 2.5)[0] == pytest.approx(piece.positions[0])


def test_a_square_that_crosses_the_picture_is_blurred_by_its_way() -> None:
    """One unit wide, one unit a frame: with a shutter of a whole frame its coverage is a tent."""
    square = replace(box(1, [[-1.0, 0, 0], [0.0, 0, 0]], [1.0, 4.0, 0.01]), look="brick")
    recording = shot([square], 1)
    camera = Camera.look_at([0, 0, 100], [0, 0, 0], fov=np.degrees(2 * np.arctan(0.01)))
    width = 128
    rows = {}
    for degrees in (0.0, 360.0):
        image = picture(recording, 1, width, 64, camera, shutter=Shutter(degrees, 32))
        rows[degrees] = image[32].astype(float).sum(axis=1)
    x = (np.arange(width) + 0.5 - width / 2) / 32.0
    still = rows[0.0]
    back, front = still[np.abs(x) > 0.7].mean(), still[np.abs(x) < 0.3].mean()
    assert abs(front - back) > 60.0
    blurred = rows[360.0]
    # Light is mixed before it is encoded: compare where the square covers nothing, all and half.
    assert blurred[x > 0.6] == pytest.approx(back, abs=6)
    assert blurred[x < -1.6] == pytest.approx(back, abs=6)
    share = (blurred - back) / (front - back)
    assert np.all(np.diff(share[(x > -1.45) & (x < -0.6)]) > -0.05)
    assert np.all(np.diff(share[(x > -0.4) & (x < 0.45)]) < 0.05)
    assert share[np.argmin(np.abs(x + 0.5))] == pytest.approx(1.0, abs=0.08)
    assert 0.3 < share[np.argmin(np.abs(x))] < 0.7


def test_what_stands_still_is_drawn_as_without_a_shutter() -> None:
    standing = shot([box(1, [[0, 0, 0]] * 3, [1, 1, 1])], 2)
    sharp = picture(standing, 2, 64, 36)
    assert np.array_equal(sharp, picture(standing, 2, 64, 36, shutter=Shutter(180.0)))
