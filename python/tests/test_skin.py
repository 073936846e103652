"""Materials, images, colours, normals and names of a mesh's file, in everything that is written."""

import struct
import zipfile
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frangible import Piece, Pieces, Recording
from frangible.io.gltf import write_pieces as write_gltf
from frangible.io.usd import write_pieces as write_usd
from frangible.materials import Image, Material
from frangible.skin import NO_MATERIAL, Skin
from pxr import Usd, UsdGeom, UsdShade
from support import CUBE_TRIANGLES, CUBE_VERTICES
from test_gltf import khronos_report, objections, parse
from test_usd import violations


def png(pixels: Any) -> bytes:
    """An image (h, w, 3) of bytes."""
    height, width, _ = pixels.shape

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    rows = b"".join(b"\0" + row.tobytes() for row in np.asarray(pixels, np.uint8))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(rows))
        + chunk(b"IEND", b"")
    )


CHECKS = png(
    np.kron(np.indices((4, 4)).sum(axis=0)[..., None] % 2 * [255, 200, 40], np.ones((4, 4, 1)))
)
IMAGE = Image("checks.png", "image/png", CHECKS)
PAINT = Material(
    (0.8, 0.7, 0.6),
    0.4,
    name="Old Paint",
    image=IMAGE,
    surface_image=Image("orm.png", "image/png", CHECKS),
)
STEEL = Material((0.5, 0.5, 0.55), 0.3, metallic=1.0, name="Steel", emission=(0.0, 0.1, 0.0))


def skin() -> Skin:
    """A cube of paint at -x and steel else, without a material at +z."""
    material = np.array([0, 0] + [1] * 8 + [NO_MATERIAL] * 2, np.int32)
    colours = np.ones((12, 3, 4), np.float32)
    colours[:2, :, 1] = 0.25
    normals = np.zeros((12, 3, 3), np.float32)
    normals[:2] = [-0.6, 0.8, 0.0]
    return Skin((PAINT, STEEL), material, colours, normals, ("House", "Front Door"))


@pytest.fixture
def pieces() -> Pieces:
    inner = np.zeros(12, bool)
    inner[10:] = True
    coordinates = np.random.default_rng(1).random((12, 3, 2)).astype(np.float32)
    piece = Piece(
        "piece_000",
        CUBE_VERTICES.astype(np.float64),
        CUBE_TRIANGLES,
        inner,
        coordinates,
        1.0,
        np.zeros(3),
        np.eye(3) / 6,
        skin(),
    )
    return Pieces("cube", [piece], [], 1.0, np.zeros(3), np.array([0.0, 1.0, 0.0]))


def test_gltf_has_materials_images_colours_normals_and_names(
    pieces: Pieces, tmp_path: Path
) -> None:
    path = tmp_path / "cube.glb"
    write_gltf(pieces, str(path))
    assert objections(khronos_report(path)["issues"]) == []
    document, read = parse(path)
    assert [material["name"] for material in document["materials"]] == [
        "Old Paint",
        "Steel",
        "inner",
    ]
    assert document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] == pytest.approx(
        [0.8, 0.7, 0.6, 1.0]
    )
    assert document["materials"][1]["emissiveFactor"] == [0.0, 0.1, 0.0]
    assert [image["name"] for image in document["images"]] == ["checks.png", "orm.png"]
    data = path.read_bytes()
    view = document["bufferViews"][document["images"][0]["bufferView"]]
    begin = 28 + struct.unpack_from("<I", data, 12)[0] + view["byteOffset"]
    assert data[begin : begin + view["byteLength"]] == CHECKS
    names = [node["name"] for node in document["nodes"]]
    assert sorted(names) == ["Front Door", "House", "cube", "piece_000"]
    primitive = document["meshes"][0]["primitives"][0]
    assert read(primitive["attributes"]["COLOR_0"])[:, 1] == pytest.approx(0.25)
    assert read(primitive["attributes"]["NORMAL"])[0] == pytest.approx([-0.6, 0.8, 0.0])
    places = read(primitive["attributes"]["TEXCOORD_0"])[read(primitive["indices"]).ravel()]
    own = pieces.pieces[0].coordinates[:2].reshape(-1, 2)
    assert places == pytest.approx(np.column_stack([own[:, 0], 1.0 - own[:, 1]]), abs=1e-6)


def test_usd_has_materials_images_colours_normals_and_names(pieces: Pieces, tmp_path: Path) -> None:
    path = tmp_path / "cube.usda"
    write_usd(pieces, str(path))
    stage = Usd.Stage.Open(str(path))
    assert violations(stage) == []
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/cube/House/Front_Door/piece_000"))
    subsets = UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets()
    assert [subset.GetPrim().GetName() for subset in subsets] == ["Old_Paint", "Steel", "inside"]
    bound = UsdShade.MaterialBindingAPI(subsets[0].GetPrim()).ComputeBoundMaterial()[0]
    assert bound.GetPrim().GetDisplayName() == "Old Paint"
    shader = UsdShade.Shader(stage.GetPrimAtPath(f"{bound.GetPath()}/image"))
    file = shader.GetInput("file").Get()
    assert Path(file.resolvedPath).read_bytes() == CHECKS
    assert Path(file.resolvedPath) == tmp_path / "cube_textures" / "checks.png"
    primvars = UsdGeom.PrimvarsAPI(mesh)
    assert np.array(primvars.GetPrimvar("displayColor").Get())[:6, 1] == pytest.approx(0.25)
    assert np.array(primvars.GetPrimvar("normals").Get())[0] == pytest.approx([-0.6, 0.8, 0.0])
    assert np.array(primvars.GetPrimvar("st").Get()) == pytest.approx(
        pieces.pieces[0].coordinates.reshape(-1, 2)
    )


def test_a_recording_keeps_its_skins(scripted: Recording, tmp_path: Path) -> None:
    bodies = [
        replace(body, skin=skin() if len(body.triangles) == 12 else None)
        for body in scripted.bodies
    ]
    recording = replace(scripted, bodies=bodies)
    recording.save(tmp_path / "slab.npz")
    again = Recording.load(tmp_path / "slab.npz")
    for body, kept in zip(bodies, (body.skin for body in again.bodies), strict=True):
        if body.skin is None:
            assert kept is None
            continue
        assert (
            kept is not None
            and kept.materials == body.skin.materials
            and kept.path == body.skin.path
        )
        for name in ("material", "colours", "normals"):
            assert np.array_equal(getattr(kept, name), getattr(body.skin, name))
    again.save(tmp_path / "slab.glb")
    assert objections(khronos_report(tmp_path / "slab.glb")["issues"]) == []
    again.save(tmp_path / "slab.usdc")
    stage = Usd.Stage.Open(str(tmp_path / "slab.usdc"))
    assert violations(stage) == []
    assert stage.GetPrimAtPath("/World/slab/House/Front_Door/slab")
    assert (tmp_path / "slab_textures" / "checks.png").read_bytes() == CHECKS


def test_one_file_of_usd_holds_the_images(scripted: Recording, tmp_path: Path) -> None:
    bodies = [
        replace(body, skin=skin() if len(body.triangles) == 12 else None)
        for body in scripted.bodies
    ]
    replace(scripted, bodies=bodies).save(tmp_path / "slab.usdz")
    assert [path.name for path in tmp_path.iterdir()] == ["slab.usdz"]
    with zipfile.ZipFile(tmp_path / "slab.usdz") as package:
        assert package.namelist()[0] == "slab.usdc"
        (image,) = (name for name in package.namelist() if name.endswith("checks.png"))
        assert package.read(image) == CHECKS


def test_a_cache_of_the_format_before_can_be_read(scripted: Recording, tmp_path: Path) -> None:
    scripted.save(tmp_path / "new.npz")
    with np.load(tmp_path / "new.npz") as arrays:
        later = (
            "paths",
            "materials",
            "image_data",
            "image_offsets",
            "material",
            "colours",
            "colour_offsets",
            "normals",
            "normal_offsets",
        )
        kept = {key: arrays[key] for key in arrays if key not in later}
    np.savez(tmp_path / "old.npz", **{**kept, "format": np.array(3)})
    again = Recording.load(tmp_path / "old.npz")
    assert [body.name for body in again.bodies] == [body.name for body in scripted.bodies]
