"""A world as bytes and back: the same bits from then on; damage answers with one sentence."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from frangible import BuildError, World
from frangible._frangible import shot_scene

#: A shot for each kind of state: polyhedra that break, level sets that do, glue, rough cracks and
#: loads, sleep, coarser patterns, triangles, bodies that were never apart. Frames, and how many of
#: them lie between two snapshots.
SHOTS = {
    "pane": (25, 6),
    "rain-25": (50, 12),
    "pillar": (30, 7),
    "bonded-pillar": (30, 7),
    "slab": (12, 3),
    "nut": (20, 9),
    "stack": (40, 1),
    "cradle": (30, 5),
}


@pytest.mark.parametrize("shot", SHOTS)
def test_restored_worlds_go_on_to_the_same_bits(shot: str) -> None:
    """Each snapshot is made of a world that came from the one before, so that equal bytes say that
    all later frames are equal, too."""
    frames, every = SHOTS[shot]
    world = World.build(shot_scene(shot))
    other = World.restore(world.snapshot())
    for frame in range(1, frames + 1):
        report, again = world.step(), other.step()
        assert world.state_hash() == other.state_hash(), frame
        assert report["fractures"] == again["fractures"]
        assert report["energy"] == again["energy"]
        if frame % every == 0:
            snapshot = world.snapshot()
            assert other.snapshot() == snapshot
            other = World.restore(snapshot)


def test_worlds_that_are_directed_go_on_to_the_same_bits() -> None:
    """Bodies that wait, are glued on a grid, follow a path, are weak somewhere, break in part, and
    come in later."""
    positions, triangles = ring()
    weak = [{"point": [-0.6, 0, 0], "factor": 0.5}, {"point": [0.6, 0, 0], "factor": 2.0}]
    cells = {"kind": "voronoi", "cells": 20}
    bodies = [
        {"shape": {"kind": "half-space"}, "motion": "static"},
        {
            "name": "ring",
            "shape": {
                "kind": "triangles",
                "positions": positions,
                "triangles": triangles,
                "resolution": {"voxels": [32, 32, 12]},
            },
            "position": [0, 0.8, 0],
            "bonds": {
                "pattern": cells,
                "tensile_strength": 1e5,
                "shear_strength": 1e5,
                "strength_points": weak,
            },
        },
        {
            "name": "wall",
            "shape": {"kind": "box", "size": [1.5, 1.5, 0.3]},
            "position": [3, 0.75, 0],
            "starts": {"when": "struck"},
            "breaking": {
                "strength": 500.0,
                "pattern": cells,
                "reach": 0.4,
                "twist": 0.3,
                "generations": 2,
                "strength_points": weak,
            },
        },
        {
            "name": "late",
            "shape": {"kind": "box", "size": [0.3, 0.3, 0.3]},
            "position": [6, 2, 0],
            "linear_velocity": [1, 0, 0],
            "starts": {"frame": 6},
        },
        {
            "name": "door",
            "motion": "kinematic",
            "shape": {"kind": "box", "size": [0.3, 0.3, 0.3]},
            "path": [{"frame": 0, "position": [8, 1, 0]}, {"frame": 20, "position": [6.5, 1, 0]}],
        },
        ball(0.6),
        ball(3.0),
    ]
    world = World.build({"bodies": bodies})
    other = World.restore(world.snapshot())
    for frame in range(1, 25):
        report, again = world.step(), other.step()
        assert world.state_hash() == other.state_hash(), frame
        assert report["energy"] == again["energy"]
        if frame % 4 == 0:
            snapshot = world.snapshot()
            assert other.snapshot() == snapshot
            other = World.restore(snapshot)
        if frame == 10:
            assert world.add_body(ball(6.0)) == other.add_body(ball(6.0))
    # The ring and the wall are broken, late and the door met.
    assert len(world.ids) > 20
    assert world.waiting.sum() == 0


def ball(x: float) -> dict[str, Any]:
    return {
        "name": "ball",
        "shape": {"kind": "sphere", "radius": 0.15},
        "position": [x, 0.8, 3],
        "linear_velocity": [0, 0, -25],
        "density": 7800,
    }


def ring() -> tuple[list[list[float]], list[list[int]]]:
    """Vertices and triangles of a torus around z."""
    around, across = np.meshgrid(np.arange(24), np.arange(12), indexing="ij")
    a, b = around.ravel() * np.pi / 12, across.ravel() * np.pi / 6
    distance = 0.6 + 0.2 * np.cos(b)
    positions = np.column_stack([distance * np.cos(a), distance * np.sin(a), 0.2 * np.sin(b)])

    def corner(i: int, j: int) -> npt.NDArray[np.int64]:
        corners: npt.NDArray[np.int64] = (around + i) % 24 * 12 + (across + j) % 12
        return corners.ravel()

    quads = corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)
    halves = [np.column_stack([quads[k] for k in half]) for half in ((0, 1, 2), (0, 2, 3))]
    return positions.tolist(), np.concatenate(halves).tolist()


def test_a_restored_world_shows_what_the_first_did() -> None:
    """Names, parents, looks, surfaces and material frames, and the method and the time."""
    world = World.build(shot_scene("pane"))
    for _ in range(20):
        world.step()
    other = World.restore(world.snapshot(), threads=1)
    assert (other.frame, other.time, other.dt) == (world.frame, world.time, world.dt)
    assert other.method == world.method
    assert other.names == world.names
    assert other.parents == world.parents
    assert other.looks == world.looks
    assert len(world.ids) > 20
    for body in world.ids.tolist():
        for array, again in zip(world.surface(body), other.surface(body), strict=True):
            assert (array == again).all()
        assert world.material_frame(body) == other.material_frame(body)


def test_pieces_share_what_they_shared() -> None:
    """What breaks on a grid shares its parent's samples: a snapshot has them once, before the break
    and after it, and the pieces of a restored world share them again."""
    world = World.build(shot_scene("wall", method="paper"))
    bodies, whole = len(world.ids), len(world.snapshot())
    while len(world.ids) == bodies:
        world.step()
        assert world.frame < 100
    assert len(world.ids) > bodies + 10
    pieces = world.snapshot()
    assert len(pieces) < 1.1 * whole
    assert World.restore(pieces).snapshot() == pieces


def test_what_is_no_snapshot_answers_with_one_sentence() -> None:
    snapshot = World.build(shot_scene("stack")).snapshot()
    World.restore(snapshot)
    cases = {
        b"": "not a snapshot of a Frangible world",
        b"PK\x03\x04" + snapshot: "not a snapshot of a Frangible world",
        snapshot[:20]: "it ends too early",
        snapshot[:-1]: "not those that were written",
        snapshot + b" ": "not those that were written",
        snapshot.replace(b"world\n\x07", b"world\n\x06", 1): "version",
        snapshot.replace(b"0.1.0-", b"0.1.1-", 1): "version",
    }
    for damaged, said in cases.items():
        with pytest.raises(BuildError, match=said) as caught:
            World.restore(damaged)
        assert str(caught.value).startswith("snapshot: ")
        assert "\n" not in str(caught.value)


def test_every_flipped_byte_is_found() -> None:
    snapshot = World.build(shot_scene("cradle")).snapshot()
    for place in range(0, len(snapshot), 37):
        damaged = bytearray(snapshot)
        damaged[place] ^= 0x10
        with pytest.raises(BuildError):
            World.restore(bytes(damaged))
