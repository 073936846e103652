"""What a glTF material says besides its colours and images: how images repeat, bright light, and
whether the back is drawn."""

import base64
import json
import struct
import zlib
from pathlib import Path
from typing import Any

import pytest
from frangible import Recording, _frangible
from frangible.breaking.break_mesh import break_mesh
from frangible.cli import main
from frangible.io.pieces_output import open_pieces_output
from pxr import Usd, UsdGeom, UsdShade

VERTICES = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
TRIANGLES = [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]


def png() -> bytes:
    def chunk(kind: bytes, data: bytes) -> bytes:
        ends = struct.pack(">I", len(data)), struct.pack(">I", zlib.crc32(kind + data))
        return ends[0] + kind + data + ends[1]

    header = struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)
    rows = chunk(b"IDAT", zlib.compress(b"\0\xff\0\0"))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + rows + chunk(b"IEND", b"")


def tetrahedron(path: Path, *, animations: int = 0) -> str:
    """A textured one: its image ends at the edge across, is mirrored down, and has hard pixels."""
    places = b"".join(struct.pack("<3f", *vertex) for vertex in VERTICES)
    coordinates = b"".join(struct.pack("<2f", *vertex[:2]) for vertex in VERTICES)
    data = places + coordinates + struct.pack("<12H", *TRIANGLES)

    def uri(content: bytes, kind: str) -> str:
        return f"data:{kind};base64,{base64.b64encode(content).decode()}"

    texture = {"baseColorTexture": {"index": 0}}
    material = {
        "name": "shade",
        "pbrMetallicRoughness": texture,
        "doubleSided": True,
        "emissiveFactor": [1.0, 0.5, 0.0],
        "emissiveTexture": {"index": 1},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 5.0}},
    }
    attributes = {"POSITION": 0, "TEXCOORD_0": 1}
    bounds = {"min": [0.0] * 3, "max": [1.0] * 3}
    file = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "scene": 0,
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 2, "material": 0}]}],
        "materials": [material],
        "textures": [{"source": 0, "sampler": 0}, {"source": 0}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9987}],
        "images": [{"uri": uri(png(), "image/png")}],
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "buffers": [{"byteLength": len(data), "uri": uri(data, "application/octet-stream")}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 24},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", **bounds},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
    }
    names = ("walk", "run", "jump")
    if animations:
        file["animations"] = [
            {"name": name, "channels": [], "samplers": []} for name in names[:animations]
        ]
    path.write_text(json.dumps(file))
    return str(path)


def check(document: dict[str, Any]) -> None:
    (material,) = [one for one in document["materials"] if one["name"] == "shade"]
    assert material["doubleSided"] is True
    strength = material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"]
    assert [strength * channel for channel in material["emissiveFactor"]] == [5.0, 2.5, 0.0]
    assert document["extensionsUsed"] == ["KHR_materials_emissive_strength"]
    index = material["pbrMetallicRoughness"]["baseColorTexture"]["index"]
    texture = document["textures"][index]
    sampler = document["samplers"][texture["sampler"]]
    assert sampler == {"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9987}
    # The same image without a sampler repeats.
    assert "sampler" not in document["textures"][material["emissiveTexture"]["index"]]


def test_they_arrive_in_gltf_and_usd(tmp_path: Path) -> None:
    path = tetrahedron(tmp_path / "a.gltf")
    pieces = break_mesh(path, _frangible.Pattern.named("voronoi", cells=6))
    for name in ("o.gltf", "o.usda"):
        open_pieces_output(str(tmp_path / name)).write(pieces)
    check(json.loads((tmp_path / "o.gltf").read_text()))
    stage = Usd.Stage.Open(str(tmp_path / "o.usda"))
    (texture,) = [prim for prim in stage.Traverse() if prim.GetName() == "image"]
    wraps = [UsdShade.Shader(texture).GetInput(key).Get() for key in ("wrapS", "wrapT")]
    assert wraps == ["clamp", "mirror"]
    meshes = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    assert meshes and any(mesh.GetDoubleSidedAttr().Get() for mesh in meshes)
    # And back.
    again = break_mesh(tmp_path / "o.usda", _frangible.Pattern.named("voronoi", cells=2))
    samplers = {
        (image.sampler.wrap_s, image.sampler.wrap_t)
        for piece in again.pieces
        if piece.skin is not None
        for material in piece.skin.materials
        for image in material.images()
    }
    assert (33071, 33648) in samplers


def test_they_arrive_through_a_run_and_its_cache(tmp_path: Path) -> None:
    path = tetrahedron(tmp_path / "a.gltf")
    shape = {"kind": "mesh", "path": path, "resolution": {"voxels": [12, 12, 12]}}
    scene = tmp_path / "s.json"
    scene.write_text(json.dumps({"frames": 1, "bodies": [{"name": "a", "shape": shape}]}))
    cache, glb = str(tmp_path / "a.npz"), tmp_path / "a.glb"
    assert main(["run", str(scene), "--quiet", "--out", cache]) == 0
    Recording.load(cache).save(glb)
    content = glb.read_bytes()
    check(json.loads(content[20 : 20 + struct.unpack("<I", content[12:16])[0]]))


def test_animations_that_are_left_out_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tetrahedron(tmp_path / "a.gltf", animations=3)
    assert main(["info", path, "--pose-time", "0"]) == 0
    said = "has 3 animations, posed by the first of them, 'walk'; left out: 'run', 'jump'"
    assert said in capsys.readouterr().err
