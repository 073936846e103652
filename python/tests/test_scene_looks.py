"""Looks of a scene's own: colours and textures outside and on cracks."""

import json
import struct
import zlib
from pathlib import Path
from typing import Any

import frangible
import numpy as np
import pytest
from frangible import Body, Box, BuildError, OwnLook, Recording, Scene, Surface, World
from frangible.cli import main


def png(red: int, green: int, blue: int) -> bytes:
    """A picture of one pixel."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        check = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + check

    head = struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)
    pixel = zlib.compress(bytes([0, red, green, blue]))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", pixel) + chunk(b"IEND", b"")


MARBLE = {
    "outside": {"image": "marble.png", "roughness": 0.3},
    "inside": {"colour": [0.5, 0.25, 0.125], "name": "broken marble"},
    "tile": 0.5,
}


def a_scene(look: Any = MARBLE) -> dict[str, Any]:
    return {
        "frames": 3,
        "materials": {
            "marble": {
                "like": "concrete",
                "look": look,
                "pattern": {"kind": "voronoi", "cells": 20},
            }
        },
        "bodies": [
            {
                "name": "slab",
                "shape": {"kind": "box", "size": [2, 2, 0.3]},
                "material": "marble",
                "breaking": {"strength": 10},
            },
            {
                "name": "ball",
                "shape": {"kind": "sphere", "radius": 0.2},
                "position": [0, 0, 0.5],
                "linear_velocity": [0, 0, -20],
            },
        ],
    }


@pytest.fixture
def path(tmp_path: Path) -> Path:
    (tmp_path / "marble.png").write_bytes(png(200, 100, 50))
    scene = tmp_path / "scene.json"
    scene.write_text(json.dumps(a_scene()))
    return scene


def test_a_look_of_ones_own_is_laid_on_body_and_pieces(path: Path) -> None:
    recording = frangible.run(path, threads=1)
    slab = recording.bodies[0]
    pieces = [body for body in recording.bodies if body.parent == slab.id]
    assert pieces and all(body.look is None for body in [slab, *pieces])
    for body in [slab, *pieces]:
        assert body.skin is not None
        outside, inside = body.skin.materials
        assert (outside.roughness, outside.name) == (0.3, "slab_outside")
        assert outside.image is not None and outside.image.data == png(200, 100, 50)
        assert (inside.colour, inside.name) == ((0.5, 0.25, 0.125), "broken marble")
        assert np.array_equal(body.skin.material, body.interior.astype(np.int32))
    # The texture covers half a metre: twice as many as of a body that nobody gave a look.
    plain = json.loads(path.read_text())
    del plain["materials"]["marble"]["look"]
    bare = frangible.run(plain, frames=1, threads=1).bodies[0]
    assert slab.coordinates == pytest.approx(2.0 * bare.coordinates)


def test_files_have_the_look(path: Path, tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    from pxr import Usd, UsdShade

    outputs = [tmp_path / f"out.{ending}" for ending in ("usda", "glb", "npz")]
    words = [word for output in outputs for word in ("--out", str(output))]
    assert main(["run", str(path), "--quiet", *words]) == 0
    stage = Usd.Stage.Open(str(outputs[0]))
    names = {prim.GetName() for prim in stage.Traverse() if prim.IsA(UsdShade.Material)}
    assert {"slab_outside", "broken_marble"} <= names
    assert (tmp_path / "out_textures" / "marble.png").read_bytes() == png(200, 100, 50)
    assert b"broken marble" in outputs[1].read_bytes()
    skin = Recording.load(outputs[2]).bodies[0].skin
    assert skin is not None and skin.materials[0].image is not None


def test_a_mesh_keeps_its_texture_coordinates(tmp_path: Path, path: Path) -> None:
    mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 3 0\nvt 0 3\n"
    mesh += "f 1/1 3/2 2/3\nf 1/1 2/2 4/3\nf 2/1 3/2 4/3\nf 1/1 4/2 3/3\n"
    (tmp_path / "rock.obj").write_text(mesh)
    shape = {"kind": "mesh", "path": str(tmp_path / "rock.obj")}
    sides = {"outside": {"colour": [1, 0, 0]}}
    body = {"name": "rock", "motion": "static", "shape": shape}
    plain = frangible.run({"bodies": [body]}, frames=1, threads=1).bodies[0]
    rock = frangible.run({"bodies": [{**body, "look": sides}]}, frames=1, threads=1).bodies[0]
    assert np.array_equal(rock.coordinates, plain.coordinates)
    assert rock.skin is not None and rock.skin.materials[0].colour == (1.0, 0.0, 0.0)


def test_the_same_in_python(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(path.parent)
    look = OwnLook(Surface(image="marble.png", roughness=0.3), tile=0.5)
    scene = Scene([Body(Box([1, 1, 1]), name="slab", look=look)])
    slab = frangible.run(scene, frames=1, threads=1).bodies[0]
    assert slab.skin is not None and slab.skin.materials[0].image is not None
    assert slab.skin.materials[1].image is not None, "the inside is as the outside"
    World.build(scene, 1)
    World.build(json.dumps(scene.to_dict()), 1)
    assert Scene.from_dict(scene.to_dict()) == scene


def test_a_look_of_ones_own_comes_back_from_a_stage(path: Path, tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    scene = Scene.load(path)
    scene.save(tmp_path / "scene.usda")
    assert Scene.load(tmp_path / "scene.usda") == scene


@pytest.mark.parametrize(
    ("look", "words"),
    [
        ({"inside": {}}, ["bodies[0].look.outside: missing", '(body "slab")']),
        ({"outside": 3}, ["bodies[0].look.outside: 3, must be an object"]),
        ({"outside": {"color": [1, 1, 1]}}, ["outside.color", "did you mean 'colour'?"]),
        ({"outsde": {}}, ["bodies[0].look.outsde", "did you mean 'outside'?"]),
        ({"outside": {"colour": [1, 2, 0]}}, ["outside.colour[1]: 2, must be a number from 0"]),
        ({"outside": {"colour": 1}}, ["outside.colour: 1, must be a list of 3 numbers"]),
        ({"outside": {"roughness": "x"}}, ['outside.roughness: "x", must be a number']),
        ({"outside": {"image": 3}}, ["outside.image: 3, must be the path of an image"]),
        ({"outside": {}, "tile": 0}, ["look.tile: 0.0, must be > 0"]),
    ],
)
def test_what_is_no_look_is_named(look: Any, words: list[str]) -> None:
    with pytest.raises(BuildError) as caught:
        frangible.run(a_scene(look), frames=1)
    said = str(caught.value)
    assert "\n" not in said and [word for word in words if word not in said] == [], said


def test_an_image_that_is_not_there_is_noted(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (path.parent / "marble.png").unlink()
    out = path.parent / "out.npz"
    assert main(["run", str(path), "--quiet", "--out", str(out)]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert "has no image 'marble.png' in its own folder" in line
