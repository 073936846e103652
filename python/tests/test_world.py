"""The compiled module: arrays, reports and errors."""

import json
import os
import subprocess
import sys
from typing import Any, get_type_hints, is_typeddict

import numpy as np
import pytest
from frangible import (
    Body,
    Box,
    BuildError,
    Recording,
    World,
    shot_defaults,
    shot_frames,
    shot_scene,
)
from frangible.report import Fracture, StepReport

BALL = {
    "name": "ball",
    "shape": {"kind": "sphere", "radius": 0.5},
    "position": [1, 2, 3],
    "density": 1000.0,
}
GROUND = {"name": "ground", "shape": {"kind": "half-space"}, "motion": "static"}


def build(*bodies: dict[str, Any], **fields: Any) -> World:
    return World.build(json.dumps({"bodies": list(bodies), **fields}))


def test_a_free_body_flies_as_newton_says() -> None:
    spin = [0.0, 2.0, 0.0]
    world = build(
        GROUND,
        {**BALL, "linear_velocity": [3, 0, 0], "angular_velocity": spin},
        gravity=[0, -10, 0],
    )
    for _ in range(6):
        report = world.step()
    t = 6 / 30
    assert (world.frame, world.dt, world.time) == (6, pytest.approx(1 / 30), pytest.approx(t))
    assert world.positions[1] == pytest.approx([1 + 3 * t, 2 - 5 * t * t, 3])
    assert world.velocities[1] == pytest.approx([3, -10 * t, 0])
    assert world.angular_velocities[1] == pytest.approx(spin)
    assert world.orientations[1] == pytest.approx([0, np.sin(t), 0, np.cos(t)])
    # Its momentum, and its angular momentum about the origin.
    mass = world.masses[1]
    assert report["momentum"]["linear"] == pytest.approx(mass * world.velocities[1])
    orbital, own = (
        mass * np.cross(world.positions[1], world.velocities[1]),
        0.4 * mass * 0.5**2 * np.array(spin),
    )
    assert report["momentum"]["angular"] == pytest.approx(orbital + own)


def test_arrays_have_a_row_for_each_body() -> None:
    world = build(GROUND, BALL, BALL)
    assert world.ids.dtype == np.uint64
    assert len(set(world.ids.tolist())) == 3
    assert (
        world.positions.shape == world.velocities.shape == world.angular_velocities.shape == (3, 3)
    )
    assert world.orientations.shape == (3, 4)
    assert world.masses == pytest.approx([np.inf, *[1000 * np.pi / 6] * 2])
    assert world.names == ["ground", "ball", "ball"]
    assert world.parents == [None, None, None]


def test_a_kinematic_body_has_infinite_mass_and_its_own_velocity() -> None:
    world = build(
        {**BALL, "motion": "kinematic", "linear_velocity": [0, 0, 4], "angular_velocity": [1, 0, 0]}
    )
    world.step()
    assert world.masses.tolist() == [np.inf]
    assert world.velocities[0].tolist() == [0, 0, 4]
    assert world.angular_velocities[0].tolist() == [1, 0, 0]
    assert world.positions[0] == pytest.approx([1, 2, 3 + 4 / 30])


def test_bodies_can_be_told_a_velocity() -> None:
    world = build({**BALL, "motion": "kinematic"}, BALL, GROUND, gravity=[0, 0, 0])
    kinematic, dynamic, ground = world.ids.tolist()
    world.set_velocity(kinematic, [0, 3, 0], np.array([0.0, 0.0, 1.0]))
    world.set_velocity(dynamic, (1, 0, 0), (0, 2, 0))
    assert world.velocities.tolist()[:2] == [[0, 3, 0], [1, 0, 0]]
    assert world.angular_velocities[1] == pytest.approx([0, 2, 0])
    for id, linear, words in [
        (ground, [1, 0, 0], ["static"]),
        (10**6, [1, 0, 0], ["1000000", "living"]),
        (dynamic, [1, 0], ["linear", "2 numbers"]),
        (dynamic, [float("nan"), 0, 0], ["linear", "NaN"]),
    ]:
        with pytest.raises(BuildError) as caught:
            world.set_velocity(id, linear, [0, 0, 0])
        assert all(word in str(caught.value) for word in words), str(caught.value)


def test_bodies_come_and_go() -> None:
    world = build(GROUND, BALL, name="come and go")
    cube = Body(Box([1, 1, 1]), name="cube", position=[0, 3, 0], material="steel")
    added = world.add_body(cube)
    assert world.names == ["ground", "ball", "cube"]
    assert world.masses[2] == pytest.approx(7800)
    assert world.step()["bodies"] == 3
    world.remove_body(int(world.ids[1]))
    assert world.ids.tolist() == [0, added]
    for act, words in [
        (lambda: world.remove_body(1), ["body: 1", "living"]),
        (lambda: world.add_body({**BALL, "density": -1}), ["body.density", "-1"]),
        (lambda: world.add_body({"shape": {"kind": "mesh", "path": "no.obj"}}), ["no.obj"]),
    ]:
        with pytest.raises(BuildError) as caught:
            act()
        assert all(word in str(caught.value) for word in words), str(caught.value)
    assert len(world.ids) == 2


def test_a_surface_lies_on_its_shape_and_faces_outward() -> None:
    world = build(GROUND, BALL)
    vertices, triangles, interior, coordinates = world.surface(int(world.ids[1]))
    assert (vertices.dtype, triangles.dtype, interior.dtype) == (np.float32, np.uint32, np.bool_)
    assert len(interior) == len(triangles) > 0
    assert not interior.any()
    assert (coordinates.dtype, coordinates.shape) == (np.float32, (len(triangles), 3, 2))
    assert np.linalg.norm(vertices, axis=1) == pytest.approx(np.full(len(vertices), 0.5), abs=0.02)
    a, b, c = vertices[triangles].astype(float).swapaxes(0, 1)
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(np.pi / 6, rel=0.05)


def test_an_id_that_is_not_alive_is_a_key_error() -> None:
    with pytest.raises(KeyError, match="12345"):
        build(BALL).surface(12345)


def test_reports_have_the_fields_that_their_types_say(wall: Recording) -> None:
    def check(value: dict[str, Any], kind: type) -> None:
        hints = get_type_hints(kind)
        # The number of pieces that a scene asked for is there only if it asked.
        assert set(hints) - set(value) <= {"wanted", "counted", "borne"}, kind.__name__
        assert set(value) <= set(hints), kind.__name__
        for key, hint in hints.items():
            if is_typeddict(hint) and key in value:
                check(value[key], hint)

    for report in wall.reports:
        check(report, StepReport)
        for fracture in report["fractures"]:
            check(fracture, Fracture)


def test_fragments_know_their_parent_and_share_its_mass(wall: Recording) -> None:
    whole = next(body for body in wall.bodies if body.name == "wall")
    pieces = [body for body in wall.alive(wall.frames) if body.source == whole.id]
    assert len(pieces) > 10
    assert {body.parent for body in pieces} == {whole.id}
    assert sum(body.mass for body in pieces) == pytest.approx(whole.mass, rel=1e-9)
    assert all(body.interior.any() for body in pieces)


def test_equal_scenes_have_equal_hashes_and_others_do_not() -> None:
    first, second, third = build(BALL), build(BALL), build({**BALL, "position": [1, 2, 3.0000001]})
    assert first.state_hash() == second.state_hash() != third.state_hash()
    first.step()
    assert first.state_hash() != second.state_hash()
    assert len(first.state_hash()) == 16


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"density": -1.0}, ["bodies[0].density", "-1.0", "between 1e-6 and 1e9 kg/m^3"]),
        ({"density": 0}, ["bodies[0].density", "between 1e-6 and 1e9 kg/m^3"]),
        ({"friction": -0.5}, ["bodies[0].friction", "-0.5", ">= 0"]),
        ({"restitution": 1.5}, ["bodies[0].restitution", "1.5", "between 0 and 1"]),
        ({"position": [0, 1e999, 0]}, ["bodies[0].position[1]", "Infinity", "finite"]),
        ({"orientation": [0, 0, 0, 0]}, ["bodies[0].orientation", "zero"]),
        (
            {"shape": {"kind": "sphere", "radius": -2}},
            ["bodies[0].shape.radius", "-2", "between 1e-6 and 1e6 m"],
        ),
        (
            {
                "shape": {
                    "kind": "box",
                    "size": [1, 1, 1],
                    "resolution": {"voxels": [4000, 4000, 4000]},
                }
            },
            ["bodies[0].shape.resolution.voxels", "4000", "at most"],
        ),
        ({"shape": {"kind": "mesh", "path": "no/such.obj"}}, ["no/such.obj", "no such file"]),
        ({"shape": {"kind": "teapot"}}, ["teapot", "sphere"]),
        ({"colour": "red"}, ["colour", "density"]),
    ],
)
def test_a_scene_that_breaks_a_rule_names_field_value_and_rule(
    change: dict[str, Any], words: list[str]
) -> None:
    with pytest.raises(BuildError) as caught:
        build({**BALL, **change})
    message = str(caught.value)
    assert "\n" not in message
    assert [word for word in words if word not in message] == [], message


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "^scene: .*line 1"),
        ("{", "^scene: .*line 1"),
        ("[]", "^scene: .*must be an object"),
        ('{"bodies": 3}', "^bodies: 3, must be a list"),
        ('{"bodies": [], "gravity": [0, NaN, 0]}', r"^gravity\[1\]: NaN, must be a finite number"),
    ],
)
def test_a_scene_that_is_no_scene_says_where(text: str, sentence: str) -> None:
    with pytest.raises(BuildError, match=sentence):
        World.build(text)


def test_shots_are_scenes_in_json() -> None:
    scene = json.loads(shot_scene("wall", fps=60.0, seed=3))
    assert scene["frames_per_second"] == 60.0
    assert World.build(json.dumps(scene)).dt == pytest.approx(1 / 60)


def test_what_is_not_asked_for_is_the_engines_default() -> None:
    defaults = shot_defaults()
    assert shot_scene("wall-ball") == shot_scene("wall-ball", **defaults)
    assert shot_frames("wall-ball") == shot_frames("wall-ball", defaults["fps"])
    scene = json.loads(shot_scene("wall-ball"))
    assert (scene["frames_per_second"], scene["method"]) == (defaults["fps"], defaults["method"])
    for method in ("paper", "frame-rate"):
        assert World.build(shot_scene("incline", method=method)).method == method
    assert shot_scene("wall-ball", seed=defaults["seed"] + 1) != shot_scene("wall-ball")


def test_freed_memory_is_kept_for_a_minute_or_as_long_as_the_environment_says() -> None:
    ask = [
        sys.executable,
        "-c",
        "from frangible import _frangible; print(_frangible._memory_kept_ms)",
    ]
    others = {name: value for name, value in os.environ.items() if not name.startswith("MIMALLOC")}
    for said, kept in [({}, 60_000), ({"MIMALLOC_PURGE_DELAY": "5"}, 5)]:
        answer = subprocess.run(ask, env=others | said, capture_output=True, text=True, check=True)
        assert int(answer.stdout) == kept


def test_added_bodies_know_the_scenes_own_materials() -> None:
    """Also in a world that was restored; a name that nobody knows is an error that lists them."""
    shape = {"kind": "box", "size": [1, 1, 1]}
    mine = {"like": "glass", "density": 1234.0, "friction": 0.01}
    floor = {"shape": {"kind": "half-space"}, "motion": "static"}
    world = World.build({"materials": {"mine": mine}, "bodies": [floor]}, 1)
    body = {"shape": shape, "position": [0, 2, 0], "material": "mine"}
    first = world.add_body(body)
    restored = World.restore(world.snapshot(), 1)
    second = restored.add_body({**body, "position": [3, 2, 0]})
    masses = dict(zip(restored.ids.tolist(), restored.masses.tolist(), strict=True))
    assert masses[first] == masses[second] == pytest.approx(1234.0)
    with pytest.raises(BuildError, match='"my", must be one of mine, concrete'):
        world.add_body({**body, "material": "my"})
    plain = World.build({"bodies": [floor]}, 1)
    assert plain.add_body({**body, "material": "glass"}) == plain.ids.tolist()[-1]
    with pytest.raises(BuildError, match="must be one of"):
        plain.add_body(body)
