"""Bodies that a script pushes, holds, cuts and breaks; and stories of the playground, natively."""

import json
import re
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


@pytest.mark.parametrize("number", [-1, 2**70, 1.0, None, "block"])
def test_what_is_no_id_is_told(number: Any) -> None:
    world, _ = block()
    three = [0, 0, 0]
    told = f"^id: {re.escape(repr(number))}, must be the id of a body, a whole number"
    for call in (
        lambda: world.apply_impulse(number, three, three),
        lambda: world.set_velocity(number, three, three),
        lambda: world.hold(number, three, three, 1),
        lambda: world.let_go(number),
        lambda: world.cut(number, three, [0, 1, 0]),
        lambda: world.burst(number, three),
        lambda: world.start(number),
        lambda: world.remove_body(number),
        lambda: world.surface(number),
        lambda: world.material_frame(number),
    ):
        with pytest.raises(BuildError, match=told):
            call()


def test_what_is_no_number_is_told() -> None:
    world, cube = block()
    unfit: Any
    for unfit, told in ((None, "None"), ("abc", "'abc'"), ([[1, 2, 3]], "[[1, 2, 3]]")):
        with pytest.raises(BuildError, match=f"^impulse: {re.escape(told)}, must be three numbers"):
            world.apply_impulse(cube, unfit, [0, 0, 0])
        with pytest.raises(BuildError, match=f"^force: {re.escape(told)}, must be a number$"):
            world.hold(cube, [0, 0, 0], [0, 0, 0], unfit)


def test_pieces_that_break_no_further_say_what_would_help() -> None:
    pane = {
        "shape": {"kind": "box", "size": [1, 1, 0.1]},
        "breaking": {"strength": 1.0, "pattern": {"kind": "voronoi", "cells": 6}},
    }
    world = World.build({"bodies": [pane]})
    pieces = world.burst(int(world.ids[0]), [0, 0, 0])
    with pytest.raises(BuildError, match="^body: a piece that breaks no further, .*generations"):
        world.burst(pieces[0], [0, 0, 0])


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
