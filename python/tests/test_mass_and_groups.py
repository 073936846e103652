"""Bodies with mass properties of their own, and bodies that pass through each other."""

import math
from typing import Any

import numpy as np
import pytest
from frangible import BuildError, World

CUBE = {"kind": "box", "size": [1, 1, 1]}
#: Corner of a cube: no axis of its inertia lies along the world's.
CORNER = {"kind": "hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}


def a_world(*bodies: dict[str, Any], gravity: float = 0.0, fps: float = 100) -> World:
    scene = {"gravity": [0, -gravity, 0], "frames_per_second": fps, "bodies": list(bodies)}
    return World.build(scene, 1)


def matrix(quaternion: Any) -> Any:
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


@pytest.mark.parametrize(
    ("shape", "center"),
    [
        (CUBE, [0.2, 0.1, -0.1]),
        (CORNER, [0.2, 0.2, 0.2]),
        ({"kind": "compound", "parts": [CUBE, {**CUBE, "position": [1, 0, 0]}]}, [0.9, 0, 0]),
        ({"kind": "sphere", "radius": 0.5}, [0, 0, 0]),
    ],
)
def test_a_symmetric_top_precesses_as_its_formula_says(
    shape: dict[str, Any], center: list[float]
) -> None:
    """Its axis turns about its angular momentum L at |L| over the moment across the axis."""
    across, along = 2.0, 3.0
    spin = np.array([1.0, 0.0, 5.0])
    # The axis of symmetry, z, is the second of the moments' axes: turned about x by a quarter.
    half = math.sqrt(0.5)
    own = {"mass": 7, "center": center, "moments": [across, along, across]}
    own["axes"] = [half, 0, 0, half]
    body = {"shape": shape, "angular_velocity": spin.tolist(), "mass_properties": own}
    world = a_world(body)
    assert world.masses.tolist() == pytest.approx([7])
    assert world.positions[0] == pytest.approx(center)
    axis = np.array([0.0, 0.0, 1.0])
    axis_body = matrix(world.orientations[0]).T @ axis
    for _ in range(100):
        world.step()
    momentum = np.array([across, across, along]) * spin
    rate = float(np.linalg.norm(momentum)) / across
    about = momentum / np.linalg.norm(momentum)
    # Rodrigues' formula, after a second.
    turned = axis * math.cos(rate) + np.cross(about, axis) * math.sin(rate)
    turned += about * (about @ axis) * (1.0 - math.cos(rate))
    assert matrix(world.orientations[0]) @ axis_body == pytest.approx(turned, abs=1e-12)


def test_a_box_stands_while_its_centre_of_mass_is_over_the_table() -> None:
    """Half of it and more sticks out over an edge."""
    table = {"shape": CUBE, "motion": "static"}
    for x, stands in ((0.25, True), (0.45, False)):
        own = {"center": [-0.35, 0, 0]} if stands else {"center": [0.35, 0, 0]}
        body = {"shape": CUBE, "position": [0.5 + x, 1, 0], "mass_properties": own}
        world = a_world(table, body, gravity=9.81, fps=30)
        for _ in range(60):
            world.step()
        assert (world.positions[1][1] > 0.9) == stands


def test_what_is_left_out_follows_from_the_shape() -> None:
    """A mass alone scales the moments; of a centre alone they are those about it."""
    for own, about in (({"mass": 3000}, 0.0), ({"mass": 3000, "center": [0.3, 0, 0]}, 0.09)):
        body = {"shape": CUBE, "density": 1000, "mass_properties": own}
        world = a_world({**body, "angular_velocity": [0, 0, 2]})
        kinetic = 0.5 * 3000 * (1 / 6 + about) * 2**2
        assert world.energy[0] == pytest.approx(kinetic)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"moments": [1, 1, 3]}, "moments: [1.0, 1.0, 3.0], must be at most the sum of the other"),
        ({"moments": [0, 1, 1]}, "moments: 0.0, must be > 0"),
        ({"center": [0, 17, 0]}, "center: [0.0, 17.0, 0.0], must be no farther from the shape"),
        ({"mass": -1}, "mass: -1.0, must be > 0"),
        ({"axes": [0, 0, 0, 0]}, "axes: [0.0, 0.0, 0.0, 0.0], must be a quaternion"),
    ],
)
def test_impossible_masses_are_refused(more: dict[str, Any], said: str) -> None:
    body = {"name": "b", "shape": CUBE, "mass_properties": {"moments": [1, 1, 1], **more}}
    with pytest.raises(BuildError) as error:
        a_world(body)
    assert said in str(error.value) and '(body "b")' in str(error.value)


def test_bodies_that_cannot_have_masses_of_their_own() -> None:
    own = {"center": [0.1, 0, 0]}
    glass = {"strength": 1.0, "pattern": {"kind": "voronoi"}}
    for body, said in (
        ({"shape": CUBE, "motion": "static"}, "on a static body"),
        ({"shape": CUBE, "breaking": glass}, "pieces have the mass of their shapes"),
        ({"shape": {"kind": "sphere", "radius": 1}}, "about its middle"),
    ):
        with pytest.raises(BuildError, match=said):
            a_world({**body, "mass_properties": own})


def head_on(**of_second: Any) -> Any:
    """Two cubes fly at each other for two seconds."""
    first = {"shape": CUBE, "position": [-2, 0, 0], "linear_velocity": [3, 0, 0]}
    second = {"shape": CUBE, "position": [2, 0, 0], "linear_velocity": [-3, 0, 0], **of_second}
    return {**first, "groups": ["ghosts", "left"]}, second


@pytest.mark.parametrize("method", ["frame-rate", "paper"])
def test_bodies_pass_through_groups(method: str) -> None:
    for of_second, passes in (
        ({}, False),
        ({"groups": ["right"], "passes_through": ["right"]}, False),
        ({"passes_through": ["left"]}, True),
        ({"groups": ["left"]}, False),
    ):
        bodies = list(head_on(**of_second))
        scene = {"gravity": [0, 0, 0], "method": method, "bodies": bodies}
        world = World.build(scene, 1)
        for _ in range(60):
            world.step()
        exact = [[4, 0, 0], [-4, 0, 0]]
        assert np.allclose(world.positions, exact, atol=1e-12) == passes, of_second


def test_groups_that_no_body_is_in_are_misspelt() -> None:
    for of_second, told in (
        ({"groups": ["left", ""]}, 'groups[1]: "", must be a name of at least one letter'),
        ({"passes_through": ["letf"]}, 'passes_through[0]: "letf", must be a group that a body'),
    ):
        bodies = list(head_on(**of_second))
        with pytest.raises(BuildError) as error:
            World.build({"bodies": bodies})
        assert str(error.value).startswith(f"bodies[1].{told}")
        # A body that is added may be in groups that are new.
        world = World.build({"bodies": bodies[:1]})
        with pytest.raises(BuildError) as error:
            world.add_body(bodies[1])
        assert str(error.value).startswith(f"body.{told}")
        world.add_body({**bodies[1], "groups": ["new"], "passes_through": ["new", "left"]})
        world.add_body({**bodies[1], "groups": [], "passes_through": ["new"]})


def test_pieces_and_added_bodies_are_in_groups_too() -> None:
    """Pieces of a pane fall through a floor that the pane passes, and a box that is added later
    likewise; another stays on it, also in a world that was restored."""
    floor = {"shape": {"kind": "box", "size": [9, 1, 9]}, "motion": "static", "groups": ["floor"]}
    pane = {
        "shape": CUBE,
        "position": [0, 3, 0],
        "breaking": {"strength": 0.1, "pattern": {"kind": "voronoi", "cells": 6}},
        "passes_through": ["floor"],
    }
    ball = {"shape": {"kind": "sphere", "radius": 0.2}, "position": [-2, 3, 0]}
    ball = {**ball, "linear_velocity": [20, 1, 0], "passes_through": ["floor"]}
    world = a_world(floor, pane, ball, gravity=9.81, fps=30)
    for _ in range(10):
        world.step()
    assert len(world.ids) > 5
    world.add_body({"shape": CUBE, "position": [3, 2, 3], "passes_through": ["floor"]})
    world = World.restore(world.snapshot())
    stays = world.add_body({"shape": CUBE, "position": [-3, 2, 3], "groups": ["others"]})
    for _ in range(60):
        world.step()
    heights = dict(zip(world.ids.tolist(), world.positions[:, 1].tolist(), strict=True))
    above = [one for one, height in heights.items() if height > -1.0]
    assert sorted(above) == sorted([world.ids.tolist()[0], stays])


def test_groups_are_lists_of_names() -> None:
    with pytest.raises(BuildError, match="groups: \"x\", must be a list of texts"):
        a_world({"shape": CUBE, "groups": "x"})
