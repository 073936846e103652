"""glTF files as they are shipped: packed, quantised, sparse, posed; and those that are refused."""

import base64
import json
import os
import re
import struct
from pathlib import Path
from typing import Any

import DracoPy
import numpy as np
import pytest
from frangible import BuildError, mesh_info, run
from frangible.cli import main
from frangible.io.gltf_document import own_file
from frangible.io.mesh_files import readable_mesh

#: A cube from (0, 0, 0) to (1, 1, 1).
CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
TRIANGLES = np.array(
    [
        (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
        (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
    ],
    np.uint16,
)  # fmt: skip

#: The same, packed by meshoptimizer: corners as singles, as exponents and as 1000ths; triangles as
#: a list and a sequence.
SINGLES = (
    "oAAAAQDAAAD/AQDAAAB+AAABDMwAAP///wEMzAAAfn1+AAABP/8AAP////////8BP/8AAH59fn1+fX4AAAAAAAAA"
    "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA=="
)
EXPONENTS = (
    "oAABAMAAAAgAAAABDMwAAAgHCAAAAAIIeHh4AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAD2AAAA9gAAAPY="
)
THOUSANDTHS = (
    "oAEAwAAALwEAwAAABgEMzAAALzAvAQzMAAAGBQYBP/8AAC8wLzAvMC8CBlZWVgAAAAAAAAAAAAAAAAAAAAAAAAAA"
    "AAAAAAAAAAAAAAAAAAAAAAAA"
)
LIST = "4f4A/w8HFqECBxORBQ8G/wIEAgMAdodWZ3iphmWJaJgBaQAA"
SEQUENCE = "0QAECAoMAggIBAoMBhIQBBIUDgQEEBIUAhYIEBYYBgoQCBYYDgAAAAA="


class Made:
    """A document that grows."""

    def __init__(self) -> None:
        self.data = b""
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {}}]}],
            "accessors": [],
            "bufferViews": [],
            "buffers": [{}],
        }

    @property
    def primitive(self) -> Any:
        return self.json["meshes"][0]["primitives"][0]

    def view(self, content: bytes, **more: Any) -> int:
        self.json["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(content), **more}
        )
        self.data += content + b"\0" * (-len(content) % 4)
        return len(self.json["bufferViews"]) - 1

    def accessor(self, rows: Any, **more: Any) -> int:
        kinds = {
            "float32": 5126,
            "int16": 5122,
            "uint16": 5123,
            "int8": 5120,
            "uint8": 5121,
            "uint32": 5125,
        }
        rows = np.asarray(rows)
        columns = 1 if rows.ndim == 1 else rows[0].size
        size = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}[columns]
        made = {
            "bufferView": self.view(rows.tobytes()),
            "componentType": kinds[rows.dtype.name],
            "count": len(rows),
        }
        self.json["accessors"].append({**made, "type": size, **more})
        return len(self.json["accessors"]) - 1

    def cube(self, corners: Any = CORNERS, **more: Any) -> "Made":
        low, high = np.min(corners, axis=0).tolist(), np.max(corners, axis=0).tolist()
        self.primitive["attributes"]["POSITION"] = self.accessor(
            corners, **{"min": low, "max": high, **more}
        )
        self.primitive["indices"] = self.accessor(TRIANGLES.ravel())
        return self

    def uses(self, *names: str) -> None:
        self.json["extensionsUsed"] = self.json["extensionsRequired"] = list(names)

    def save(self, folder: Path, ending: str = "glb") -> str:
        path = folder / f"made.{ending}"
        self.json["buffers"][0]["byteLength"] = len(self.data)
        if ending == "gltf":
            self.json["buffers"][0]["uri"] = "made%20of.bin"
            (folder / "made of.bin").write_bytes(self.data)
            path.write_text(json.dumps(self.json))
            return str(path)
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        chunks = (
            struct.pack("<I4s", len(text), b"JSON")
            + text
            + struct.pack("<I4s", len(self.data), b"BIN\0")
            + self.data
        )
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
        return str(path)


def info(path: str, pose_time: float | None = None) -> dict[str, Any]:
    with readable_mesh(path, pose_time) as file:
        return mesh_info(file)


def is_cube(facts: dict[str, Any], low: Any = (0, 0, 0), high: Any = (1, 1, 1)) -> None:
    assert facts["watertight"] and facts["triangles"] == 12
    assert facts["low_m"] == pytest.approx(low, abs=1e-6) and facts["high_m"] == pytest.approx(
        high, abs=1e-6
    )
    assert facts["volume_m3"] == pytest.approx(np.prod(np.subtract(high, low)), rel=1e-5)


@pytest.mark.parametrize("ending", ["glb", "gltf"])
def test_rows_of_a_sparse_accessor_are_others(tmp_path: Path, ending: str) -> None:
    made = Made().cube()
    rows, places = CORNERS[4:] + np.float32([1, 0, 0]), np.arange(4, 8, dtype=np.uint8)
    accessor = made.json["accessors"][0]
    accessor["sparse"] = {
        "count": 4,
        "indices": {"bufferView": made.view(places.tobytes()), "componentType": 5121},
        "values": {"bufferView": made.view(rows.astype(np.float32).tobytes())},
    }
    is_cube(info(made.save(tmp_path, ending)), high=(2, 1, 1))
    # Without a view all others are zeros.
    places = np.arange(8, dtype=np.uint8)
    del accessor["bufferView"]
    accessor["sparse"] = {
        "count": 8,
        "indices": {"bufferView": made.view(places.tobytes()), "componentType": 5121},
        "values": {"bufferView": made.view(CORNERS.tobytes())},
    }
    is_cube(info(made.save(tmp_path, ending)))
    accessor["sparse"]["indices"]["bufferView"] = made.view(bytes([0, 1, 2, 3, 4, 5, 6, 9]))
    with pytest.raises(BuildError, match="accessor 0 has a sparse index 9, must be below 8"):
        info(made.save(tmp_path, ending))


@pytest.mark.parametrize(
    ("dtype", "normalized", "unit"),
    [
        ("int16", False, 1),
        ("uint16", True, 65535),
        ("int8", True, 127),
        ("uint8", False, 1),
        ("int16", True, 32767),
    ],
)
def test_quantised_positions_are_read(
    tmp_path: Path, dtype: str, normalized: bool, unit: int
) -> None:
    # Rows are four bytes or eight apart, as glTF asks for.
    wide = np.zeros((8, 4), dtype)
    wide[:, :3] = CORNERS * unit
    made = Made().cube()
    view = made.view(wide.tobytes(), byteStride=wide.strides[0])
    kind = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123}[dtype]
    made.json["accessors"][0] |= {
        "bufferView": view,
        "componentType": kind,
        "normalized": normalized,
    }
    made.json["nodes"][0] |= {"scale": [2, 2, 2], "translation": [5, 0, 0]}
    made.uses("KHR_mesh_quantization")
    is_cube(info(made.save(tmp_path)), low=(5, 0, 0), high=(7, 2, 2))


@pytest.mark.parametrize("extension", ["EXT_meshopt_compression", "KHR_meshopt_compression"])
@pytest.mark.parametrize(
    ("corners", "filter"), [(SINGLES, "NONE"), (EXPONENTS, "EXPONENTIAL"), (THOUSANDTHS, None)]
)
@pytest.mark.parametrize(("indices", "mode"), [(LIST, "TRIANGLES"), (SEQUENCE, "INDICES")])
def test_what_meshoptimizer_packed_is_unpacked(
    tmp_path: Path, extension: str, corners: str, filter: str | None, indices: str, mode: str
) -> None:
    made = Made().cube()
    views = made.json["bufferViews"]
    # The fallback buffer has no bytes.
    made.json["buffers"].append({"byteLength": 168, "extensions": {extension: {"fallback": True}}})
    stride = 12 if filter else 8
    for number, (text, packed) in enumerate(
        [
            (
                corners,
                {
                    "byteStride": stride,
                    "count": 8,
                    "mode": "ATTRIBUTES",
                    **({"filter": filter} if filter else {}),
                },
            ),
            (indices, {"byteStride": 2, "count": 36, "mode": mode}),
        ]
    ):
        data = base64.b64decode(text)
        at = len(made.data)
        made.data += data + b"\0" * (-len(data) % 4)
        extensions = {extension: {"buffer": 0, "byteOffset": at, "byteLength": len(data), **packed}}
        views[number] = {
            "buffer": 1,
            "byteLength": packed["byteStride"] * packed["count"],
            "extensions": extensions,
        }
    views[0]["byteStride"] = stride
    if not filter:
        made.json["accessors"][0]["componentType"] = 5122
        made.json["nodes"][0]["scale"] = [0.001] * 3
    made.uses(extension, "KHR_mesh_quantization")
    is_cube(info(made.save(tmp_path)))

    # Damaged.
    packed = views[0]["extensions"][extension]
    for key, value, sentence in (
        ("byteLength", 20, "view 0 holds no ATTRIBUTES that can be unpacked"),
        ("byteStride", 7, "view 0 has 8 rows of 7 bytes"),
        ("mode", "WORDS", "must be ATTRIBUTES, TRIANGLES or INDICES"),
        (
            "filter",
            "OCTAHEDRAL" if filter else "QUARTZ",
            "which ATTRIBUTES and OCTAHEDRAL do not have|unknown filter",
        ),
        ("count", 10**10, "unpacks to more than"),
    ):
        before = dict(packed)
        packed[key] = value
        with pytest.raises(BuildError, match=sentence):
            info(made.save(tmp_path))
        packed.clear()
        packed.update(before)


def test_what_draco_packed_is_unpacked(tmp_path: Path) -> None:
    made = Made().cube(CORNERS + np.float32(3.0))
    data = DracoPy.encode(
        CORNERS + np.float32(3.0), TRIANGLES.astype(np.uint32), quantization_bits=14
    )
    view = made.view(data)
    made.primitive["extensions"] = {
        "KHR_draco_mesh_compression": {"bufferView": view, "attributes": {"POSITION": 0}}
    }
    # A packed file has no views.
    for accessor in made.json["accessors"]:
        del accessor["bufferView"]
    made.uses("KHR_draco_mesh_compression")
    facts = info(made.save(tmp_path))
    assert facts["volume_m3"] == pytest.approx(1.0, rel=1e-3) and facts["low_m"] == pytest.approx(
        [3, 3, 3], abs=1e-3
    )

    # Damaged.
    made.json["bufferViews"][view]["byteLength"] = 30
    with pytest.raises(BuildError, match="made.glb: is not a readable glTF file"):
        info(made.save(tmp_path))


def test_without_the_package_for_draco_it_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = Made().cube()
    made.uses("KHR_draco_mesh_compression")
    monkeypatch.setattr("frangible.extras.find_spec", lambda _: None)
    with pytest.raises(
        BuildError, match=r"is compressed with Draco: .*pip install 'frangible\[gltf\]'"
    ):
        info(made.save(tmp_path))


def swing() -> Made:
    """A cube that moves by 2 along x and turns by a right angle about z, and grows, within a
    second."""
    made = Made().cube()
    times = made.accessor(np.float32([0, 1]), min=[0], max=[1])
    half = np.sqrt(0.5)
    values = {
        "translation": np.float32([[0, 0, 0], [2, 0, 0]]),
        "rotation": np.float32([[0, 0, 0, 1], [0, 0, half, half]]),
    }
    outputs = {path: made.accessor(rows) for path, rows in values.items()}
    made.json["animations"] = [
        {
            "samplers": [{"input": times, "output": output} for output in outputs.values()],
            "channels": [
                {"sampler": n, "target": {"node": 0, "path": path}}
                for n, path in enumerate(outputs)
            ],
        }
    ]
    return made


def test_nodes_are_posed_at_a_time(tmp_path: Path) -> None:
    path = swing().save(tmp_path)
    is_cube(info(path))
    is_cube(info(path, 0.0))
    is_cube(info(path, 1.0), low=(1, 0, 0), high=(2, 1, 1))
    # After the last key it stays.
    is_cube(info(path, 9.0), low=(1, 0, 0), high=(2, 1, 1))
    half = info(path, 0.5)
    # Half of a right angle, half of the way.
    diagonal = np.sqrt(0.5)
    assert half["low_m"] == pytest.approx([1 - diagonal, 0, 0], abs=1e-6)
    assert half["high_m"] == pytest.approx([1 + diagonal, 2 * diagonal, 1], abs=1e-6)


@pytest.mark.parametrize(
    ("interpolation", "at"), [("STEP", 0.0), ("LINEAR", 0.5), ("CUBICSPLINE", 0.3125)]
)
def test_keys_are_interpolated_as_the_animation_says(
    tmp_path: Path, interpolation: str, at: float
) -> None:
    made = swing()
    sampler = made.json["animations"][0]["samplers"][0]
    sampler["interpolation"] = interpolation
    if interpolation == "CUBICSPLINE":
        # In-tangent, value, out-tangent of each key.
        rows = np.float32([[0, 0, 0], [0, 0, 0], [0, 0, 0], [3, 0, 0], [2, 0, 0], [0, 0, 0]])
        sampler["output"] = made.accessor(rows)
    made.json["animations"][0]["channels"].pop()
    # Tangents of 3 at the end pull back by 3/8 half way.
    is_cube(info(made.save(tmp_path), 0.5), low=(2 * at, 0, 0), high=(2 * at + 1, 1, 1))


def test_morph_targets_follow_their_weights(tmp_path: Path) -> None:
    made = Made().cube()
    grown = np.zeros((8, 3), np.float32)
    grown[4:, 0] = 1.0
    made.primitive["targets"] = [{"POSITION": made.accessor(grown, min=[0, 0, 0], max=[1, 0, 0])}]
    is_cube(info(made.save(tmp_path)))
    made.json["meshes"][0]["weights"] = [0.5]
    is_cube(info(made.save(tmp_path)), high=(1.5, 1, 1))
    # A node's own weights count more, and an animation's most.
    made.json["nodes"][0]["weights"] = [2.0]
    is_cube(info(made.save(tmp_path)), high=(3, 1, 1))
    times, weights = (
        made.accessor(np.float32([0, 2]), min=[0], max=[2]),
        made.accessor(np.float32([0, 1])),
    )
    made.json["animations"] = [
        {
            "samplers": [{"input": times, "output": weights}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
        }
    ]
    is_cube(info(made.save(tmp_path), 1.0), high=(1.5, 1, 1))


def test_skins_follow_their_joints_and_not_their_node(tmp_path: Path) -> None:
    made = Made().cube()
    # Left and right follow a joint each; each was at x = 10 when they were bound.
    made.primitive["attributes"]["JOINTS_0"] = made.accessor(
        np.uint8([[int(x), 0, 0, 0] for x, _, _ in CORNERS])
    )
    made.primitive["attributes"]["WEIGHTS_0"] = made.accessor(
        np.uint8([[255, 0, 0, 0]] * 8), normalized=True
    )
    bind = np.eye(4, dtype=np.float32)
    bind[0, 3] = -10.0
    made.json["skins"] = [
        {"joints": [1, 2], "inverseBindMatrices": made.accessor(np.array([bind.T, bind.T]))}
    ]
    made.json["nodes"] = [
        {"mesh": 0, "skin": 0, "translation": [7, 7, 7], "scale": [9, 9, 9]},
        {"translation": [10, 0, 0], "children": [2]},
        {"translation": [3, 0, 0]},
    ]
    made.json["scenes"][0]["nodes"] = [0, 1]
    is_cube(info(made.save(tmp_path)), high=(4, 1, 1))
    # At some time the first joint has moved, and the second with it.
    times = made.accessor(np.float32([0, 1]), min=[0], max=[1])
    way = made.accessor(np.float32([[10, 0, 0], [10, 4, 0]]))
    made.json["animations"] = [
        {
            "samplers": [{"input": times, "output": way}],
            "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
        }
    ]
    is_cube(info(made.save(tmp_path), 0.5), low=(0, 2, 0), high=(4, 3, 1))
    # A joint that is not there.
    made.json["skins"][0]["joints"] = [1]
    with pytest.raises(BuildError, match="the joints of a primitive do not fit its skin"):
        info(made.save(tmp_path))


def test_instances_are_nodes_and_what_is_hidden_is_none(tmp_path: Path) -> None:
    made = Made().cube()
    places = made.accessor(np.float32([[0, 0, 0], [3, 0, 0], [6, 0, 0]]))
    scales = made.accessor(np.float32([[1, 1, 1], [1, 2, 1], [1, 1, 1]]))
    attributes = {"TRANSLATION": places, "SCALE": scales}
    made.json["nodes"] = [
        {
            "mesh": 0,
            "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}},
            "translation": [0, 1, 0],
        },
        {"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": False}}, "children": [2]},
        {"mesh": 0},
    ]
    made.json["scenes"][0]["nodes"] = [0, 1]
    made.uses("EXT_mesh_gpu_instancing", "KHR_node_visibility")
    facts = info(made.save(tmp_path))
    assert (facts["parts"], facts["volume_m3"]) == (3, pytest.approx(4.0))
    assert (facts["low_m"], facts["high_m"]) == (pytest.approx([0, 1, 0]), pytest.approx([7, 3, 1]))


def test_textures_of_extensions_do_no_harm_and_unknown_extensions_are_refused(
    tmp_path: Path,
) -> None:
    made = Made().cube()
    made.json["images"] = [{"uri": "no.ktx2"}]
    made.json["textures"] = [{"extensions": {"KHR_texture_basisu": {"source": 0}}}, {}]
    info_of = {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}}
    made.json["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": info_of}}]
    made.primitive["material"] = 0
    made.uses("KHR_texture_basisu", "KHR_texture_transform", "KHR_materials_unlit")
    with pytest.warns(UserWarning, match="has no image 'no.ktx2' in its own folder"):
        is_cube(info(made.save(tmp_path)))
    made.uses("KHR_gaussian_splatting")
    with pytest.raises(
        BuildError,
        match="made.glb: requires the extension KHR_gaussian_splatting, which is not read",
    ):
        info(made.save(tmp_path))


def test_files_of_version_1_are_named_as_such(tmp_path: Path) -> None:
    made = Made().cube()
    # Its lists are objects by name.
    made.json |= {"asset": {"version": "1.0"}, "skins": {}, "nodes": {"box": {}}}
    with pytest.raises(BuildError, match="made.glb: is glTF of version 1.0, must be of version 2"):
        info(made.save(tmp_path))


def test_whole_commands_take_packed_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = Made().cube(CORNERS.astype(np.int16))
    made.uses("KHR_mesh_quantization")
    path = made.save(tmp_path)
    assert main(["info", path]) == 0
    assert re.search(r"^volume_m3 +1$", capsys.readouterr().out, re.MULTILINE)
    out = str(tmp_path / "pieces.glb")
    assert (
        main(["break", path, "--pattern", "slices", "--cells", "3", "--voxels", "16", "--out", out])
        == 0
    )
    assert main(["info", out]) == 0
    assert "mesh" in [body.name for body in run("impact", mesh=path, frames=1, threads=1).bodies]
    moving = swing().save(tmp_path)
    capsys.readouterr()
    assert main(["info", moving, "--pose-time", "1"]) == 0
    assert re.search(r"^low_m +1 0 0$", capsys.readouterr().out, re.MULTILINE)


@pytest.mark.parametrize(
    "name",
    [
        "../out.bin", "a/../../out.bin", "{folder}/out.bin", "file://{folder}/out.bin",
        "/dev/zero", "link.bin",
        "..%2Fout.bin", "http://a/b.bin", "a\\..\\b",
    ],
)  # fmt: skip
@pytest.mark.parametrize("is_plain", [True, False])
def test_buffers_lie_in_the_documents_own_folder(tmp_path: Path, name: str, is_plain: bool) -> None:
    own = tmp_path / "own"
    own.mkdir()
    made = Made().cube()
    if not is_plain:
        made.uses("KHR_mesh_quantization")
    path = made.save(own, "gltf")
    (tmp_path / "out.bin").write_bytes(made.data)
    os.symlink(tmp_path / "out.bin", own / "link.bin")
    is_cube(info(path))
    made.json["buffers"][0]["uri"] = name.format(folder=tmp_path)
    Path(path).write_text(json.dumps(made.json))
    with pytest.raises(BuildError, match="must be a file in the document's own folder"):
        info(path)


def test_files_below_the_folder_are_its_own(tmp_path: Path) -> None:
    assert own_file(str(tmp_path / "a.gltf"), "bin/a%20b.bin") == str(tmp_path / "bin" / "a b.bin")
    assert own_file(str(tmp_path / "a.gltf"), "bin/./a.bin") == str(tmp_path / "bin" / "a.bin")


@pytest.mark.parametrize("is_plain", [True, False])
def test_a_pipe_is_no_buffer(tmp_path: Path, is_plain: bool) -> None:
    made = Made().cube()
    if not is_plain:
        made.uses("KHR_mesh_quantization")
    path = made.save(tmp_path, "gltf")
    os.unlink(tmp_path / "made of.bin")
    os.mkfifo(tmp_path / "made of.bin")
    with pytest.raises(BuildError, match="must be a regular file"):
        info(path)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("nodes", 7), ("nodes", [{"mesh": "a"}]), ("nodes", [{"children": [0]}]),
        ("nodes", [{"children": [1]}, {"children": [0]}]),
        ("accessors", [{}]), ("meshes", [{}]), ("bufferViews", [{"buffer": 0, "byteLength": 1e10}]),
        ("scenes", [[]]), ("textures", [3]),
        ("accessors", [{"type": "VEC9", "count": 3, "componentType": 5126}]),
        ("accessors", [{"type": "VEC3", "count": 10**10, "componentType": 5126}] * 2),
        ("nodes", [{"mesh": 0, "scale": ["a"]}]),
    ],
)  # fmt: skip
def test_whatever_is_damaged_gets_one_sentence(tmp_path: Path, key: str, value: Any) -> None:
    made = Made().cube()
    made.uses("KHR_mesh_quantization")
    made.json[key] = value
    path = made.save(tmp_path)
    with pytest.raises(BuildError) as error:
        info(path)
    sentence = str(error.value)
    assert sentence.startswith(f"{path}: ") and "\n" not in sentence and len(sentence) < 300, (
        sentence
    )
