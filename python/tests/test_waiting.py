"""Bodies that wait, from Python: scenes, arrays, reports and what is refused."""

import json
from pathlib import Path

import frangible
import numpy as np
import pytest
from frangible import Body, Box, BuildError, HalfSpace, Scene, Sphere, Starts, World


def scene(**starts: object) -> Scene:
    """A ball flies at a box in the air, which it reaches in frame 6."""
    box = Body(Box([0.4] * 3), name="box", position=[0, 3, 0], starts=Starts.from_dict(starts))
    ball = Body(Sphere(0.1), name="ball", position=[-1.4, 3.2, 0], linear_velocity=[6, 0, 0])
    return Scene([Body(HalfSpace(), name="ground", motion="static"), box, ball])


def test_it_is_the_same_from_a_file(tmp_path: Path) -> None:
    waits = scene(when="struck")
    for ending in (".json", ".toml"):
        waits.save(tmp_path / f"scene{ending}")
        assert Scene.load(tmp_path / f"scene{ending}") == waits
    text = (tmp_path / "scene.json").read_text()
    assert json.loads(text)["bodies"][1]["starts"] == {"when": "struck"}


def test_arrays_and_reports_say_who_waits() -> None:
    world = World.build(scene(when="struck").to_dict(), 1)
    assert world.waiting.tolist() == [False, True, False]
    # It has its mass already, but no share in the energy.
    assert world.masses[1] == pytest.approx(2400 * 0.4**3)
    (kinetic, potential) = world.energy
    assert kinetic + potential == pytest.approx(world.masses[2] * (18 + 9.81 * 3.2), rel=1e-9)
    for frame in range(1, 9):
        report = world.step()
        waits = frame < 6
        assert report["waiting"] == waits == bool(world.waiting[1]), frame
        assert np.array_equal(world.positions[1], [0, 3, 0]) == waits
        started = world.masses[1] * 9.81 * 3 if frame == 6 else 0.0
        assert report["energy"]["started"] == pytest.approx(started, rel=1e-9)
    assert world.velocities[1, 0] > 0.1


def test_a_script_starts_it() -> None:
    world = World.build(scene(frame=90).to_dict(), 1)
    box = int(world.ids[1])
    with pytest.raises(BuildError, match="body: waiting, must be started before"):
        world.set_velocity(box, [0, 1, 0], [0, 0, 0])
    assert world.start(box)
    world.set_velocity(box, [0, 1, 0], [0, 0, 0])
    world.step()
    assert world.positions[1, 1] > 3.0
    assert not world.start(box) and not world.waiting.any()


def test_a_recording_shows_it_from_the_first_frame() -> None:
    recording = frangible.run(scene(frame=4), frames=8, threads=1)
    box = next(body for body in recording.bodies if body.name == "box")
    heights = box.positions[:, 1]
    assert heights[:5].tolist() == [3.0] * 5 and heights[5] < 3.0
    assert np.isfinite(box.mass)


@pytest.mark.parametrize(
    ("starts", "words"),
    [
        ({}, ["bodies[1].starts: with neither 'frame' nor 'when'", '(body "box")']),
        ({"frame": 1, "when": "struck"}, ["bodies[1].starts: with both 'frame' and 'when'"]),
        ({"frame": -1}, ["bodies[1].starts.frame", "-1"]),
        ({"when": "hit"}, ["bodies[1].starts.when", "hit", "struck"]),
        ({"wen": "struck"}, ["bodies[1].starts", "wen", "did you mean 'when'?"]),
    ],
)
def test_what_is_no_start_is_named(starts: dict[str, object], words: list[str]) -> None:
    fields = scene(when="struck").to_dict()
    fields["bodies"][1]["starts"] = starts
    with pytest.raises(BuildError) as error:
        World.build(fields, 1)
    assert [word for word in words if word not in str(error.value)] == [], str(error.value)


@pytest.mark.parametrize("motion", ["static", "kinematic"])
def test_what_does_not_move_by_itself_does_not_wait(motion: str) -> None:
    fields = scene(when="struck").to_dict()
    fields["bodies"][1]["motion"] = motion
    with pytest.raises(BuildError, match=f"bodies.1..starts: on a {motion} body, must be left out"):
        World.build(fields, 1)


def test_the_papers_method_waits_for_frames_only() -> None:
    fields = {**scene(when="struck").to_dict(), "method": "paper"}
    with pytest.raises(BuildError, match="starts.when: struck, must be a frame"):
        World.build(fields, 1)
    fields["bodies"][1]["starts"] = {"frame": 2}
    world = World.build(fields, 1)
    heights = []
    for _ in range(4):
        world.step()
        heights.append(world.positions[1, 1])
    assert heights[:2] == [3.0, 3.0] and heights[2] < 3.0
