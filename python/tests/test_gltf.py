"""glTF files: valid by the Khronos validator, and true to the recording."""

import json
import struct
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frangible import Recording
from support import TOOLS


def khronos_report(path: Path) -> dict[str, Any]:
    run = subprocess.run(
        ["node", TOOLS / "validate_gltf.js", path],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    report: dict[str, Any] = json.loads(run.stdout)
    return report


def objections(issues: dict[str, Any]) -> list[dict[str, Any]]:
    """All messages but the remark that no texture uses the coordinates: they wait for the
    user's."""
    return [
        one
        for one in issues["messages"]
        if one["code"] != "UNUSED_OBJECT" or not one["pointer"].endswith("/TEXCOORD_0")
    ]


def parse(path: Path) -> tuple[dict[str, Any], Any]:
    """The JSON chunk, and a function that reads an accessor of the binary chunk."""
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    document, binary = json.loads(data[20 : 20 + length]), data[28 + length :]

    def read(index: int) -> np.ndarray:
        accessor = document["accessors"][index]
        columns = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        begin = (
            document["bufferViews"][accessor["bufferView"]]["byteOffset"] + accessor["byteOffset"]
        )
        kind = {5126: np.float32, 5125: np.uint32}[accessor["componentType"]]
        return np.frombuffer(binary, kind, accessor["count"] * columns, begin).reshape(-1, columns)

    return document, read


@pytest.fixture(scope="module")
def path(scripted: Recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("gltf") / "slab.glb"
    scripted.save(path)
    return path


def test_the_khronos_validator_finds_nothing(path: Path, wall: Recording, tmp_path: Path) -> None:
    wall.save(tmp_path / "wall.glb")
    for file in (path, tmp_path / "wall.glb"):
        issues = khronos_report(file)["issues"]
        assert objections(issues) == []
        assert issues["numErrors"] == issues["numWarnings"] == 0


def test_the_khronos_validator_does_object_to_a_broken_file(path: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken.glb"
    broken.write_bytes(path.read_bytes().replace(b'"VEC4"', b'"VEC2"'))
    assert khronos_report(broken)["issues"]["numErrors"] > 0


def test_every_frame_shows_what_the_recording_shows(path: Path, scripted: Recording) -> None:
    document, read = parse(path)
    (animation,) = document["animations"]
    nodes = {node["name"]: index for index, node in enumerate(document["nodes"]) if "mesh" in node}
    assert list(nodes) == ["ground", "slab", "slab_2", "slab_4", "slab_5"]

    def at(node: int, target: str, seconds: float, rest: list[float]) -> np.ndarray:
        for channel in animation["channels"]:
            if channel["target"] == {"node": node, "path": target}:
                sampler = animation["samplers"][channel["sampler"]]
                times, values = read(sampler["input"])[:, 0], read(sampler["output"])
                # All frames are keys, so a player need not interpolate.
                key = max(int(np.searchsorted(times, seconds + 1e-6)) - 1, 0)
                return values[key]
        return np.array(document["nodes"][node].get(target, rest))

    for frame in range(scripted.frames + 1):
        for body, node in zip(scripted.bodies, nodes.values(), strict=True):
            seconds = frame / scripted.fps
            size = at(node, "scale", seconds, [1.0, 1.0, 1.0])
            assert size.tolist() == ([1.0] * 3 if body.alive(frame) else [0.0] * 3), (
                body.id,
                frame,
            )
            if body.alive(frame):
                position, orientation = body.pose(frame)
                assert at(node, "translation", seconds, [0.0] * 3) == pytest.approx(
                    position, abs=1e-6
                )
                assert at(node, "rotation", seconds, [0.0] * 4) == pytest.approx(
                    orientation, abs=1e-6
                )


def test_constant_channels_are_dropped_and_times_shared(path: Path) -> None:
    document, _ = parse(path)
    (animation,) = document["animations"]
    names = [
        document["nodes"][channel["target"]["node"]]["name"] for channel in animation["channels"]
    ]
    assert "ground" not in names
    assert [
        c["target"]["path"]
        for c, name in zip(animation["channels"], names, strict=True)
        if name == "slab_5"
    ] == ["scale"]
    moving = [
        sampler["input"]
        for sampler in animation["samplers"]
        if sampler["interpolation"] == "LINEAR"
    ]
    assert len(moving) == 4
    assert len(set(moving)) == 2


def test_cracks_are_a_primitive_with_a_material_of_their_own(path: Path) -> None:
    document, read = parse(path)
    mesh = next(
        document["meshes"][node["mesh"]] for node in document["nodes"] if node["name"] == "slab_4"
    )
    names = [
        document["materials"][primitive["material"]]["name"] for primitive in mesh["primitives"]
    ]
    assert names == ["slab", "inside"]
    assert [len(read(primitive["indices"])) // 3 for primitive in mesh["primitives"]] == [8, 4]
    # The cracks of the piece in the middle are its two faces across x.
    inside = read(mesh["primitives"][1]["attributes"]["NORMAL"])
    assert np.abs(inside[:, 0]) == pytest.approx(np.ones(len(inside)))


def test_textures_are_as_large_as_what_they_lie_on(path: Path) -> None:
    document, read = parse(path)
    mesh = next(
        document["meshes"][node["mesh"]] for node in document["nodes"] if node["name"] == "slab_4"
    )
    for primitive in mesh["primitives"]:
        positions, places = (
            read(primitive["attributes"][key]) for key in ("POSITION", "TEXCOORD_0")
        )
        assert len(places) == len(positions)
        indices = read(primitive["indices"]).reshape(-1, 3)
        sides = np.roll(indices, -1, axis=1)
        in_space = np.linalg.norm(positions[sides] - positions[indices], axis=2)
        assert np.linalg.norm(places[sides] - places[indices], axis=2) == pytest.approx(in_space)


def test_equal_shapes_share_a_mesh(scripted: Recording, tmp_path: Path) -> None:
    twin = replace(scripted.body(5), id=6, name="twin")
    replace(scripted, bodies=[*scripted.bodies, twin]).save(tmp_path / "twins.glb")
    document, _ = parse(tmp_path / "twins.glb")
    meshes = {node["name"]: node["mesh"] for node in document["nodes"] if "mesh" in node}
    assert meshes["twin"] == meshes["slab_5"]
    assert len(document["meshes"]) == len(scripted.bodies)


def test_glass_is_clear_and_the_rest_is_not(path: Path) -> None:
    document, _ = parse(path)
    materials = {material["name"]: material for material in document["materials"]}
    assert set(materials) == {"ground", "slab", "inside", "glass_outside", "glass_inside"}
    alpha = {
        name: material["pbrMetallicRoughness"]["baseColorFactor"][3]
        for name, material in materials.items()
    }
    assert alpha["glass_outside"] < alpha["glass_inside"] < 1.0
    assert {
        name for name, material in materials.items() if material.get("alphaMode") == "BLEND"
    } == {"glass_outside", "glass_inside"}
    assert alpha["slab"] == alpha["inside"] == alpha["ground"] == 1.0
