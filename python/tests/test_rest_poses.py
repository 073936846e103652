"""What a run broke is put together again from its cache alone."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from frangible import Body, Recording, run
from frangible.recording import rotation_matrix

Float64 = npt.NDArray[np.float64]

#: Shots, how many frames of them break something, by which method, and how far the volume of the
#: surfaces may be off: polyhedra, parts of balls, which are drawn round, glued polyhedra, and
#: pieces of a grid, whose surfaces are found anew for each.
BREAKS: dict[str, tuple[int, str | None, float]] = {
    "pane": (10, None, 1e-6),
    "rain-25": (30, None, 1e-3),
    "bonded-pillar": (40, None, 1e-5),
    "wall": (12, "paper", 1e-3),
}


@pytest.fixture(scope="module", params=BREAKS)
def cache(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    frames, method, _ = BREAKS[request.param]
    path = tmp_path_factory.mktemp("cache") / "cache.npz"
    run(request.param, frames=frames, method=method).save(path)
    return Recording.load(path)


def breaks(recording: Recording) -> list[tuple[Body, dict[str, Any], list[Body]]]:
    """The bodies that broke and all of whose pieces a frame shows."""
    known = {body.id: body for body in recording.bodies}
    return [
        (known[fracture["body"]], fracture, [known[piece] for piece in fracture["fragments"]])
        for report in recording.reports
        for fracture in map(dict, report["fractures"])
        if {fracture["body"], *fracture["fragments"]} <= set(known)
    ]


def volume(vertices: Float64, body: Body) -> float:
    a, b, c = vertices[body.triangles].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def in_parent(piece: Body, rest: dict[str, Any]) -> Float64:
    """Vertices of a piece in its parent's body frame."""
    turn = rotation_matrix(np.array(rest["orientation"]))
    turned: Float64 = piece.vertices.astype(np.float64) @ turn.T + rest["position"]
    return turned


def test_pieces_fill_their_parent(cache: Recording) -> None:
    """Volume and centre of mass to 1e-9 from exact numbers, and to single precision from the
    surfaces."""
    found = breaks(cache)
    assert found
    off = BREAKS[cache.shot][2]
    for parent, fracture, pieces in found:
        volumes = np.array([piece.volume for piece in pieces])
        assert volumes.sum() == pytest.approx(parent.volume, rel=1e-9)
        rests = np.array([rest["position"] for rest in fracture["rest_poses"]])
        size = np.ptp(parent.vertices, axis=0).max()
        assert np.abs(volumes @ rests).max() < 1e-9 * size * volumes.sum()
        placed = [in_parent(*both) for both in zip(pieces, fracture["rest_poses"], strict=True)]
        of_surfaces = sum(map(volume, placed, pieces))
        assert of_surfaces == pytest.approx(volume(parent.vertices, parent), rel=off)
        corners = np.concatenate(placed)
        low, high = parent.vertices.min(axis=0), parent.vertices.max(axis=0)
        grain = 2e-2 * size
        assert np.all(corners > low - grain) and np.all(corners < high + grain)
        assert np.allclose(corners.min(axis=0), low, atol=grain)
        assert np.allclose(corners.max(axis=0), high, atol=grain)


def test_every_break_says_when_where_and_by_what(cache: Recording) -> None:
    known = {body.id: body for body in cache.bodies}
    for report in cache.reports:
        for fracture in report["fractures"]:
            assert fracture["time"] == pytest.approx(report["time"] - 1.0 / cache.fps)
            assert fracture["striker"] in known
            assert fracture["impulse"] >= fracture["borne"] >= 0.0
            assert fracture["energy"] >= 0.0
            assert np.isfinite(fracture["point"]).all()
            assert len(fracture["rest_poses"]) == len(fracture["fragments"])


def test_the_contact_graph_holds_the_pieces_together(cache: Recording) -> None:
    """All pieces hang together, each pair once, with unit normals and points within the parent."""
    for parent, fracture, pieces in breaks(cache):
        contacts = fracture["contacts"]
        pairs = [tuple(contact["pieces"]) for contact in contacts]
        assert all(0 <= a < b < len(pieces) for a, b in pairs)
        assert all(first < second for first, second in pairwise(pairs))
        group = list(range(len(pieces)))
        for a, b in pairs:
            old, new = group[a], group[b]
            group = [new if each == old else each for each in group]
        assert len(set(group)) == 1
        low, high = parent.vertices.min(axis=0), parent.vertices.max(axis=0)
        for contact in contacts:
            assert contact["area"] > 0.0
            assert np.linalg.norm(contact["normal"]) == pytest.approx(1.0)
            assert np.all(contact["point"] > low - 1e-6) and np.all(contact["point"] < high + 1e-6)


def test_areas_of_contacts_are_those_of_the_cracks() -> None:
    """Of polyhedra: the cracks of each piece's surface are what its contacts cover, to 1 %."""
    recording = run("pane", frames=10)
    ((_, fracture, pieces),) = breaks(recording)
    areas = [0.0] * len(pieces)
    for contact in fracture["contacts"]:
        for piece in contact["pieces"]:
            areas[piece] += contact["area"]
    assert len(pieces) > 100
    for piece, rest, area in zip(pieces, fracture["rest_poses"], areas, strict=True):
        a, b, c = in_parent(piece, rest)[piece.triangles].transpose(1, 0, 2)
        cracks = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)[piece.interior].sum()
        assert area == pytest.approx(cracks, rel=1e-2), piece

def test_a_cube_in_two_halves_is_what_geometry_says() -> None:
    """A cube of edge 1 cut in its middle: the contact is a square of 1 m^2."""
    scene = {
        "bodies": [
            {
                "name": "cube",
                "shape": {"kind": "box", "size": [1, 1, 1]},
                "position": [0, 0.5, 0],
                "breaking": {
                    "strength": 1.0,
                    "pattern": {"kind": "slices", "cells": 2, "jitter": 0},
                },
            },
            {
                "name": "ball",
                "shape": {"kind": "sphere", "radius": 0.2},
                "position": [0, 1.25, 0],
                "linear_velocity": [0, -5, 0],
                "density": 7800,
            },
        ]
    }
    recording = run(scene, frames=3)
    ((parent, fracture, pieces),) = breaks(recording)
    assert len(pieces) == 2
    assert parent.volume == pytest.approx(1.0, rel=1e-12)
    (contact,) = fracture["contacts"]
    assert contact["area"] == pytest.approx(1.0, rel=1e-9)
    assert contact["pieces"] == [0, 1]
