"""Blender shows at every frame what the recording says is alive; `make test-blender` runs this."""

import json
import os
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frangible import Recording
from frangible.convention import Convention
from frangible.names import by_source, unique_names
from frangible.stage_camera import StageCamera

BLENDER = os.environ.get("BLENDER_PYTHON")
LOOK = Path(__file__).parents[2] / "tests" / "blender" / "look.py"

pytestmark = pytest.mark.skipif(BLENDER is None, reason="needs BLENDER_PYTHON, a Python with bpy")


def look(recording: Recording, path: Path) -> dict[str, Any]:
    recording.save(path)
    command = [str(BLENDER), str(LOOK), str(path), str(recording.frames)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    lines = [line for line in done.stdout.splitlines() if line.startswith("LOOK ")]
    assert lines, done.stderr
    answer: dict[str, Any] = json.loads(lines[0].removeprefix("LOOK "))
    return answer


def names_in_blender(recording: Recording, seen: dict[str, Any]) -> dict[str, int]:
    """The body of each object; Blender adds .001 to a name that a parent has already."""
    names = {}
    for family in by_source(recording.bodies).values():
        pieces = zip(family, unique_names(body.name for body in family), strict=True)
        for body, name in pieces:
            for candidate in (name, f"{name}.001"):
                if candidate in seen["materials"]:
                    names[candidate] = body.id
    return names


def check(recording: Recording, seen: dict[str, Any]) -> None:
    names = names_in_blender(recording, seen)
    assert sorted(names.values()) == sorted(body.id for body in recording.bodies)
    for frame in range(recording.frames + 1):
        alive = {body.id for body in recording.alive(frame)}
        assert {names[name] for name in seen["shown"][frame]} == alive, frame
        for name, place in seen["shown"][frame].items():
            body = recording.body(names[name])
            x, y, z = body.pose(frame)[0]
            # Blender's z is up.
            assert place == pytest.approx([x, -z, y], abs=1e-3), (name, frame)
    for name, body_id in names.items():
        body = recording.body(body_id)
        sides = len(np.unique(body.interior)) if len(body.interior) else 1
        assert seen["used"][name] == sides, name
        assert len(seen["materials"][name]) >= sides
        assert all(seen["materials"][name])


@pytest.mark.parametrize("ending", ["usdc", "usda", "glb", "abc"])
def test_every_frame_shows_what_is_alive(ending: str, scripted: Recording, tmp_path: Path) -> None:
    if ending == "abc":
        pytest.importorskip("alembic3d")
    seen = look(scripted, tmp_path / f"slab.{ending}")
    check(scripted, seen)


@pytest.mark.parametrize("ending", ["usdc", "glb"])
def test_the_wall_too(ending: str, wall: Recording, tmp_path: Path) -> None:
    # Blender's scene keeps 24 frames a second, and places what glTF has in seconds at those.
    check(replace(wall, fps=24.0), look(replace(wall, fps=24.0), tmp_path / f"wall.{ending}"))


def test_blender_takes_over_the_frames_of_the_stage(scripted: Recording, tmp_path: Path) -> None:
    assert look(scripted, tmp_path / "slab.usdc")["frames"] == [0, scripted.frames]


@pytest.mark.parametrize("camera", ["fit", "stage"])
def test_blender_draws_what_we_draw(camera: str, scripted: Recording, tmp_path: Path) -> None:
    """The same camera, and each piece where ours is, moved by the same way."""
    from frangible.cli import main
    from PIL import Image

    # A camera that flies by, four frames in the time of three.
    cameras = ()
    if camera == "stage":
        eyes = tuple((x, 3.0, 9.0) for x in np.linspace(-6.0, 3.0, 9))
        still, lens = (0.0, 0.0, 0.0, 1.0), (0.5, 0.3)
        cameras = (StageCamera("/Cam", 32.0, eyes, (still,) * 9, (lens,) * 9),)
    replace(scripted, convention=Convention(cameras=cameras)).save(tmp_path / "slab.npz")
    seen = {}
    for renderer in ("own", "blender"):
        out = tmp_path / f"{renderer}.png"
        options = ["--frame", "3", "--size", "160x90", "--renderer", renderer, "--quiet"]
        options += ["--shutter", "180", "--samples", "8", "--camera", camera]
        assert main(["render", str(tmp_path / "slab.npz"), "--out", str(out), *options]) == 0
        with Image.open(out) as image:
            colours = np.asarray(image.convert("RGB")).astype(int)
        # Cracks, and colours of sources, are warmer than the grey floor and the sky.
        seen[renderer] = colours[..., 0] - colours[..., 2] > 12
    own, blender = seen["own"], seen["blender"]
    assert own.sum() > 100
    assert (own & blender).sum() > 0.6 * (own | blender).sum()
    middles = [np.argwhere(colours).mean(axis=0) for colours in (own, blender)]
    assert middles[0] == pytest.approx(middles[1], abs=2.0)


def test_pieces_are_where_they_came_from_before_they_are_seen(scripted: Recording) -> None:
    from frangible.io.blender import shown_to_shutter

    early = {body.id: body for body in shown_to_shutter(scripted).bodies}
    piece, slab = scripted.body(4), scripted.body(1)
    assert piece.before is not None
    assert early[4].birth_frame == piece.birth_frame - 1 == early[1].death_frame
    assert early[4].positions[0] == pytest.approx(piece.before[:3])
    assert early[4].positions[1:] == pytest.approx(piece.positions)
    assert early[1].positions == pytest.approx(slab.positions)
