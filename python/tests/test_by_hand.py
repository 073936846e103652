"""Bodies that a script pushes, holds, cuts and breaks; and stories of the playground, natively."""

import json
from pathlib import Path
from typing import Any

import frangible
import numpy as np
import pytest
from frangible import Body, Box, BuildError, HalfSpace, Scene, World
from frangible.recorder import Recorder

STORIES = Path(__file__).resolve().parents[2] / "web" / "test"


def block() -> tuple[World, int]:
    """A cube of 1000 kg in space."""
    scene = Scene([Body(Box([1, 1, 1]), name="block", density=1000)], gravity=[0, 0, 0])
    world = World.build(scene.to_dict(), 1)
    return world, int(world.ids[0])


def test_an_impulse_does_work() -> None:
    world, cube = block()
    assert world.apply_impulse(cube, [0, 0, 500], np.zeros(3)) == pytest.approx(125)
    assert world.velocities[0].tolist() == [0, 0, 0.5]
    assert world.step()["energy"]["work"] == pytest.approx(125)


def test_a_hand_pulls_until_it_lets_go() -> None:
    world, cube = block()
    world.hold(cube, [0, 0, 0], [1, 0, 0], force=1e4)
    work = sum(world.step()["energy"]["work"] for _ in range(60))
    assert world.positions[0] == pytest.approx([1, 0, 0], abs=1e-3)
    assert world.let_go(cube) and not world.let_go(cube)
    assert abs(work) < 1


def test_pieces_of_a_cut_are_recorded() -> None:
    world, cube = block()
    recorder = Recorder(world)
    recorder.capture(world.step())
    halves = world.cut(cube, [0, 0.1, 0], [0, 1, 0])
    report = world.step()
    recorder.capture(report)
    assert report["fractures"][0]["fragments"] == halves
    assert sorted(world.masses) == pytest.approx([400, 600])
    recording = recorder.finish("cut", 30)
    parents = [body.parent for body in recording.bodies]
    assert parents == [None, 0, 0]


def test_what_is_unbreakable_does_not_burst() -> None:
    world, cube = block()
    with pytest.raises(BuildError, match="^body: unbreakable, must be breakable$"):
        world.burst(cube, [0, 0, 0])
    with pytest.raises(BuildError, match="^normal: .*, must be longer than 0$"):
        world.cut(cube, [0, 0, 0], [0, 0, 0])
    scene = Scene([Body(HalfSpace(), motion="static")])
    ground = World.build(scene.to_dict(), 1)
    with pytest.raises(BuildError, match="^body: static, must be dynamic$"):
        ground.hold(0, [0, 0, 0], [0, 0, 0], 1)


def do(world: World, action: dict[str, Any]) -> None:
    """What the page's worker does: `web/src/playground/simulator.ts`."""
    match action:
        case {"add": body}:
            world.add_body(body)
        case {"hold": {"body": body, "point": point, "target": target, "force": force}}:
            world.hold(body, point, target, force)
        case {"letGo": body}:
            world.let_go(body)
        case {"cut": {"body": body, "point": point, "normal": normal}}:
            assert world.cut(body, point, normal)
        case {"burst": {"body": body, "point": point, "speed": speed}}:
            assert world.burst(body, point, speed)
        case _:
            raise AssertionError(action)


@pytest.mark.parametrize("name", ["story.json", "deeds.json"])
def test_stories_of_the_playground_end_in_the_same_state(name: str) -> None:
    story = json.loads((STORIES / name).read_text(encoding="utf-8"))
    world = frangible.World.build(story["scene"], 1)
    actions = list(story["actions"])
    for frame in range(story["frames"]):
        while actions and actions[0]["frame"] == frame:
            do(world, actions.pop(0))
        world.step()
    assert not actions
    assert world.state_hash() == story["hash"]
