"""Blender shows at every frame what the recording says is alive; `make test-blender` runs this."""

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frangible import Recording
from frangible.names import by_source, unique_names

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


@pytest.mark.parametrize("ending", ["usdc", "usda", "glb"])
def test_every_frame_shows_what_is_alive(ending: str, scripted: Recording, tmp_path: Path) -> None:
    seen = look(scripted, tmp_path / f"slab.{ending}")
    check(scripted, seen)


@pytest.mark.parametrize("ending", ["usdc", "glb"])
def test_the_wall_too(ending: str, wall: Recording, tmp_path: Path) -> None:
    from dataclasses import replace

    # Blender's scene keeps 24 frames a second, and places what glTF has in seconds at those.
    check(replace(wall, fps=24.0), look(replace(wall, fps=24.0), tmp_path / f"wall.{ending}"))


def test_blender_takes_over_the_frames_of_the_stage(scripted: Recording, tmp_path: Path) -> None:
    assert look(scripted, tmp_path / "slab.usdc")["frames"] == [0, scripted.frames]
