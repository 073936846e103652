"""Attributes of a mesh's file arrive in the pieces: both ways, all formats, through simulations
too."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import frangible
import numpy as np
import pytest
from frangible import Pattern, Piece, Pieces, Recording, break_mesh
from frangible.cli import main
from frangible.io.gltf import write_pieces as write_gltf
from frangible.io.usd import write_pieces as write_usd
from frangible.materials import Image, Material
from frangible.skin import Skin
from pxr import Usd, UsdGeom, UsdShade
from support import CUBE_TRIANGLES, CUBE_VERTICES
from test_gltf import khronos_report, objections, parse
from test_skin import CHECKS

#: Coordinates and colours are linear in space, so that what is right anywhere is known.
TO_UV = np.array([[0.3, 0.2], [0.1, -0.25], [0.2, 0.15]])
TO_RGB = np.array([[0.1, 0.0, 0.05], [0.0, 0.3, 0.0], [0.0, 0.2, -0.3]])
PAINT = Material(
    (1.0, 0.9, 0.8), 0.4, name="Old Paint", image=Image("checks.png", "image/png", CHECKS)
)
STEEL = Material((0.5, 0.5, 0.55), 0.3, metallic=1.0, name="Steel")


def uv(points: Any) -> Any:
    return np.asarray(points) @ TO_UV + 0.5


def rgb(points: Any) -> Any:
    return np.asarray(points) @ TO_RGB + 0.5


def cube(name: str, offset: float, materials: list[int], path: tuple[str, ...]) -> Piece:
    """At x = offset: two materials by the faces' axes, with everything else."""
    vertices = CUBE_VERTICES.astype(np.float64) + [offset, 0.0, 0.0]
    corners = vertices[CUBE_TRIANGLES]
    colours = np.concatenate([rgb(corners), np.ones((12, 3, 1))], axis=2).astype(np.float32)
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.repeat(
        (faces / np.linalg.norm(faces, axis=1, keepdims=True))[:, None], 3, axis=1
    ).astype(np.float32)
    skin = Skin((PAINT, STEEL), np.repeat(materials, 4).astype(np.int32), colours, normals, path)
    return Piece(
        name,
        vertices,
        CUBE_TRIANGLES,
        np.zeros(12, bool),
        uv(corners).astype(np.float32),
        1.0,
        np.array([offset, 0.0, 0.0]),
        np.eye(3) / 6,
        skin,
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("skins")


@pytest.fixture(scope="module")
def gltf_file(folder: Path) -> Path:
    two = [
        cube("left", 0.0, [0, 1, 0], ("House", "Door")),
        cube("right", 3.0, [1, 1, 1], ("House", "Window")),
    ]
    write_gltf(
        Pieces("home", two, [], 2.0, np.zeros(3), np.array([0.0, 1.0, 0.0])),
        str(folder / "home.glb"),
    )
    return folder / "home.glb"


@pytest.fixture(scope="module")
def usd_file(folder: Path) -> Path:
    two = [
        cube("left", 0.0, [0, 1, 0], ("House", "Door")),
        cube("right", 3.0, [1, 1, 1], ("House", "Window")),
    ]
    write_usd(
        Pieces("home", two, [], 2.0, np.zeros(3), np.array([0.0, 1.0, 0.0])),
        str(folder / "home.usdc"),
    )
    return folder / "home.usdc"


@pytest.fixture(scope="module")
def obj_file(folder: Path) -> Path:
    """The same without colours, in quads."""
    (folder / "checks.png").write_bytes(CHECKS)
    (folder / "home.mtl").write_text(
        "newmtl Old Paint\nKd 1 0.9 0.8\nmap_Kd checks.png\nnewmtl Steel\nKd 0.5 0.5 0.55\nPm "
        "1\nPr 0.3\n"
    )
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    lines, first = ["mtllib home.mtl"], 1
    for name, offset, materials in (("Door", 0.0, "PPSSPP"), ("Window", 3.0, "SSSSSS")):
        vertices = CUBE_VERTICES.astype(np.float64) + [offset, 0.0, 0.0]
        lines.append(f"o {name}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
        lines += [f"vt {u:.9g} {v:.9g}" for u, v in uv(vertices).tolist()]
        for quad, letter in zip(quads, materials, strict=True):
            lines.append("usemtl " + {"P": "Old Paint", "S": "Steel"}[letter])
            lines.append("f " + " ".join(f"{first + corner}/{first + corner}" for corner in quad))
        first += 8
    (folder / "home.obj").write_text("\n".join(lines))
    return folder / "home.obj"


def check(pieces: list[Any], tolerance: float, colours: bool, normals: bool) -> None:
    """Pieces have vertices, triangles, inner and coordinates in the frame of the file."""
    seen, clear, whole = set(), 0.0, 0.0
    for vertices, triangles, inner, coordinates, skin in pieces:
        outer = ~inner
        corners = vertices[triangles[outer]]
        assert np.abs(coordinates[outer] - uv(corners)).max(initial=0.0) < tolerance
        if colours:
            assert np.abs(skin.colours[outer][..., :3] - rgb(corners)).max(initial=0.0) < tolerance
            assert np.all(skin.colours[inner] == 1.0)
        faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        # Rims of a grid are a little round.
        units = faces / np.linalg.norm(faces, axis=1, keepdims=True)
        flat = np.abs(units).max(axis=1) > 0.99
        sizes = np.linalg.norm(faces, axis=1)
        clear += float(sizes[flat].sum())
        whole += float(sizes.sum())
        if normals:
            cosine = np.einsum("tkj,tj->tk", skin.normals[outer], units)
            assert cosine[flat].min(initial=1.0) > 0.98
            assert np.all(skin.normals[inner] == 0.0)
        # Paint is on x and z of the left one.
        axis = np.argmax(np.abs(faces), axis=1)
        is_paint = (corners[:, :, 0].mean(axis=1) < 1.5) & (axis != 1)
        names = np.array([*(material.name for material in skin.materials), "none"])[skin.material]
        assert (names[outer] == np.where(is_paint, "Old Paint", "Steel"))[flat].all()
        seen.add(skin.path)
    assert clear > 0.7 * whole
    assert {name for path in seen for name in path} >= {"Door", "Window"}


@pytest.mark.parametrize("exact", [True, False])
@pytest.mark.parametrize("kind", ["gltf", "usd", "obj"])
def test_pieces_keep_what_the_file_says(
    kind: str, exact: bool, request: pytest.FixtureRequest
) -> None:
    path = request.getfixturevalue(f"{kind}_file")
    pieces = break_mesh(
        path, Pattern.named("voronoi", cells=14), exact=exact, voxels=80, inside="Core"
    )
    surfaces = [(p.vertices, p.triangles, p.inner, p.coordinates, p.skin) for p in pieces.pieces]
    check(surfaces, 1e-5 if exact else 0.025, kind != "obj", kind != "obj")
    for piece in pieces.pieces:
        assert piece.skin is not None
        materials = [
            piece.skin.materials[index] for index in np.unique(piece.skin.material[piece.inner])
        ]
        assert [material.name for material in materials] == ["Core"] * int(piece.inner.any())
    paint = next(
        m for p in pieces.pieces if p.skin for m in p.skin.materials if m.name == "Old Paint"
    )
    assert paint.image is not None and paint.image.data == CHECKS
    assert paint.colour == pytest.approx((1.0, 0.9, 0.8))


def test_without_coordinates_outer_faces_have_metres(folder: Path) -> None:
    path = folder / "plain.obj"
    lines = ["v %r %r %r" % tuple(v) for v in (10 * CUBE_VERTICES.astype(float)).tolist()]
    path.write_text(
        "\n".join([*lines, *("f %d %d %d" % tuple(t) for t in (CUBE_TRIANGLES + 1).tolist())])
    )
    for piece in break_mesh(path, Pattern.named("voronoi", cells=6), exact=True).pieces:
        u, v = np.moveaxis(piece.coordinates.astype(np.float64), 2, 0)
        corners = piece.vertices[piece.triangles]
        areas = np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        )
        measured = np.abs(
            (u[:, 1] - u[:, 0]) * (v[:, 2] - v[:, 0]) - (u[:, 2] - u[:, 0]) * (v[:, 1] - v[:, 0])
        )
        assert measured == pytest.approx(areas, abs=1e-4)
        assert piece.skin is None


def test_colours_of_vertices_in_ply(folder: Path) -> None:
    head = ["ply", "format ascii 1.0", "element vertex 8", *(f"property float {a}" for a in "xyz")]
    head += [
        *(f"property uchar {c}" for c in ("red", "green", "blue")),
        "element face 12",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    rows = ["%g %g %g %d 0 255" % (*v, 255 * (v[0] > 0)) for v in CUBE_VERTICES.tolist()]
    path = folder / "cube.ply"
    path.write_text(
        "\n".join([*head, *rows, *("3 %d %d %d" % tuple(t) for t in CUBE_TRIANGLES.tolist())])
    )
    for piece in break_mesh(path, Pattern.named("voronoi", cells=6), exact=True).pieces:
        assert piece.skin is not None and piece.skin.colours is not None
        outer = ~piece.inner
        red = piece.vertices[piece.triangles[outer]][..., 0] + 0.5
        assert piece.skin.colours[outer][..., 0] == pytest.approx(red, abs=1e-5)
        assert [
            piece.skin.materials[i].corner_colours for i in np.unique(piece.skin.material[outer])
        ] == [True]


def test_an_image_that_ply_names_arrives(folder: Path) -> None:
    (folder / "checks.png").write_bytes(CHECKS)
    head = [
        "ply",
        "format ascii 1.0",
        "comment TextureFile checks.png",
        "comment TextureFile lost.png",
    ]
    head += ["element vertex 8", *(f"property float {axis}" for axis in "xyz"), "element face 12"]
    head += ["property list uchar int vertex_indices", "property list uchar float texcoord"]
    head += ["property int texnumber", "end_header"]
    rows = ["%g %g %g" % tuple(v) for v in CUBE_VERTICES.tolist()]
    for number, corners in enumerate(CUBE_TRIANGLES.tolist()):
        places = " ".join(
            f"{value:.9g}" for value in uv(CUBE_VERTICES[corners].astype(np.float64)).ravel()
        )
        rows.append(f"3 {corners[0]} {corners[1]} {corners[2]} 6 {places} {int(number > 5)}")
    path = folder / "images.ply"
    path.write_text("\n".join([*head, *rows]) + "\n")
    with pytest.warns(match="has no image 'lost.png' in its own folder"):
        broken = break_mesh(path, Pattern.named("voronoi", cells=6), exact=True)
    shown = {}
    for piece in broken.pieces:
        assert piece.skin is not None
        outer = ~piece.inner
        corners = piece.vertices[piece.triangles[outer]]
        assert piece.coordinates[outer] == pytest.approx(uv(corners), abs=1e-5)
        shown |= {m.name: m.image for m in piece.skin.materials}
    assert shown["checks"] is not None and shown["checks"].data == CHECKS
    assert shown["lost"] is None


@pytest.mark.parametrize("kind", ["gltf", "usd", "obj"])
def test_files_of_pieces_have_materials_images_and_names(
    kind: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    path = str(request.getfixturevalue(f"{kind}_file"))
    command = ["break", path, "--pattern", "voronoi", "--cells", "40", "--inside", "Core", "--out"]
    assert main([*command, str(tmp_path / "out.glb")]) == 0
    assert objections(khronos_report(tmp_path / "out.glb")["issues"]) == []
    document, _ = parse(tmp_path / "out.glb")
    assert {material["name"] for material in document["materials"]} == {
        "Old Paint",
        "Steel",
        "Core",
    }
    assert len(document["images"]) == 1
    assert {"Door", "Window"} <= {node["name"] for node in document["nodes"]}
    assert main([*command, str(tmp_path / "out.usdc")]) == 0
    stage = Usd.Stage.Open(str(tmp_path / "out.usdc"))
    meshes = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    names = {name for mesh in meshes for name in str(mesh.GetPath()).split("/")}
    assert names >= {"Door", "Window"}
    bound = {
        UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()[0].GetPrim().GetName()
        for mesh in meshes
        for subset in UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets()
    }
    assert bound == {"Old_Paint", "Steel", "Core"}
    assert (tmp_path / "out_textures" / "checks.png").read_bytes() == CHECKS
    assert main([*command, str(tmp_path / "out.obj")]) == 0
    again = break_mesh(tmp_path / "out.obj", Pattern.named("voronoi", cells=3), exact=True)
    names = {m.name for p in again.pieces if p.skin for m in p.skin.materials}
    assert {"Old Paint", "Steel", "Core"} <= names


@pytest.mark.parametrize("kind", ["gltf", "usd"])
def test_a_run_keeps_what_the_file_says(
    kind: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    path = str(request.getfixturevalue(f"{kind}_file"))
    out = tmp_path / "run.npz"
    assert (
        main(
            [
                "run",
                "impact",
                "--mesh",
                path,
                "--frames",
                "14",
                "--threads",
                "1",
                "--inside",
                "Core",
                "--out",
                str(out),
            ]
        )
        == 0
    )
    recording = Recording.load(out)
    bodies = [body for body in recording.bodies if body.skin is not None]
    assert len(bodies) > 3 and any(body.interior.any() for body in bodies)
    for body in bodies:
        assert body.skin is not None
        used = {body.skin.materials[i].name for i in np.unique(body.skin.material).tolist()}
        assert used <= {"Old Paint", "Steel", "Core"}
        assert all(
            body.skin.materials[i].name == "Core"
            for i in np.unique(body.skin.material[body.interior])
        )
    # Before anything moves the body is the scaled mesh: four units are two metres.
    first = bodies[0]
    points = first.vertices_world(0)
    low = points.min(axis=0)
    in_file = (points - low) * 2.0 - 0.5
    # It is made of both objects, so of what is above them.
    assert first.skin is not None and first.skin.path[-1:] == ("House",)
    entry = (in_file, first.triangles, first.interior, first.coordinates)
    check(
        [(*entry, replace(first.skin, path=(name,))) for name in ("Door", "Window")],
        0.03,
        True,
        False,
    )


THIN = {
    "glass": ([1.0, 1.0, 0.004], 0.004),
    "pane": ([2.0, 1.0, 0.001], 0.002),
    "tilted": ([3.0, 0.002, 1.0], 0.006),
}


@pytest.mark.parametrize("name", THIN)
def test_thin_parts_have_their_volume_everywhere(
    name: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    size, volume = THIN[name]
    path = folder / f"{name}.obj"
    lines = ["v %r %r %r" % tuple(v) for v in (CUBE_VERTICES.astype(float) * size).tolist()]
    path.write_text(
        "\n".join([*lines, *("f %d %d %d" % tuple(t) for t in (CUBE_TRIANGLES + 1).tolist())])
    )
    out = tmp_path / "pieces.glb"
    command = [
        "break",
        str(path),
        "--pattern",
        "voronoi",
        "--cells",
        "8",
        "--json",
        "--out",
        str(out),
    ]
    assert main(command) == 0
    summary = json.loads(capsys.readouterr().out)
    assert (
        summary["volume_m3"] == pytest.approx(volume, rel=1e-6) and summary["volume_defect"] < 1e-9
    )
    assert frangible.mesh_info(path)["volume_m3"] == pytest.approx(volume, rel=1e-6)

    # A grid whose voxels are wider leaves them as they are, and says so.
    assert main([*command, "--grid", "--voxels", "64"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["volume_m3"] == pytest.approx(volume, rel=1e-6)
    assert summary["volume_defect"] < 1e-9
    assert "1 part thinner than a voxel keeps its own surface" in summary["notes"]


def test_what_crosses_itself_is_not_cut_exactly(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from test_break import knotted_tube

    vertices, triangles = knotted_tube()
    path = folder / "knot.obj"
    rows = ["v %r %r %r" % tuple(v) for v in vertices.tolist()] + [
        "f %d %d %d" % tuple(t) for t in (triangles + 1).tolist()
    ]
    path.write_text("\n".join(rows))
    command = [
        "break",
        str(path),
        "--pattern",
        "voronoi",
        "--cells",
        "6",
        "--voxels",
        "40",
        "--out",
        str(tmp_path / "p.glb"),
    ]
    assert main([*command, "--exact"]) == 2
    assert (
        "a surface that crosses itself, must have none to be cut exactly" in capsys.readouterr().err
    )
    assert main(command) == 0
    assert "made anew" in capsys.readouterr().out


def test_without_the_library_the_grid_stands_in(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = folder / "brick.obj"
    lines = ["v %r %r %r" % tuple(v) for v in CUBE_VERTICES.astype(float).tolist()]
    path.write_text(
        "\n".join([*lines, *("f %d %d %d" % tuple(t) for t in (CUBE_TRIANGLES + 1).tolist())])
    )
    monkeypatch.setattr("frangible.extras.find_spec", lambda _: None)
    pieces = break_mesh(path, Pattern.named("voronoi", cells=5), voxels=32)
    assert pieces.notes[-1].startswith(
        "cutting the mesh itself needs an optional package, install it with: pip install"
    )
