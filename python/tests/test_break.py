"""Breaking meshes without a simulation: closed pieces that add up, files that are valid, sentences
that help."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import frangible
import numpy as np
import pytest
from frangible import Pattern, Piece, Pieces, break_mesh
from frangible._frangible import load_mesh, mesh_mass
from frangible.breaking.exact_cut import arrays, cut, labelled
from frangible.cli import main
from manifold3d import Manifold
from pxr import Usd, UsdGeom, UsdShade
from support import CUBE_TRIANGLES, CUBE_VERTICES
from test_gltf import khronos_report, objections
from test_usd import violations

Mesh = tuple[np.ndarray, np.ndarray]


def grid_surface(across: int, around: int, place: Callable[[Any, Any], Any]) -> Mesh:
    """A surface of squares that is closed both ways, each cut into two triangles."""
    u, v = np.meshgrid(np.arange(across), np.arange(around), indexing="ij")
    vertices = place(2 * np.pi * u.ravel() / across, 2 * np.pi * v.ravel() / around)
    a, b = u * around + v, (u + 1) % across * around + v
    c, d = (u + 1) % across * around + (v + 1) % around, u * around + (v + 1) % around
    return vertices, np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(
        -1, 3
    )


def torus() -> Mesh:
    def place(u: Any, v: Any) -> Any:
        return np.stack(
            [(1 + 0.4 * np.cos(v)) * np.cos(u), 0.4 * np.sin(v), (1 + 0.4 * np.cos(v)) * np.sin(u)],
            -1,
        )

    vertices, triangles = grid_surface(40, 24, place)
    return vertices, triangles[:, ::-1]


def open_sphere() -> Mesh:
    """Of squares between parallels, with a round hole at each pole."""
    rows, columns = 19, 32
    polar = np.linspace(0.2, np.pi - 0.2, rows)[:, None]
    turn = 2 * np.pi * np.arange(columns) / columns
    vertices = np.stack(
        [np.sin(polar) * np.cos(turn), np.cos(polar) + 0 * turn, np.sin(polar) * np.sin(turn)], -1
    ).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns), indexing="ij")
    a, b = i * columns + j, (i + 1) * columns + j
    c, d = (i + 1) * columns + (j + 1) % columns, i * columns + (j + 1) % columns
    return vertices, np.concatenate([np.stack([a, c, b], -1), np.stack([a, d, c], -1)]).reshape(
        -1, 3
    )


def box(low: list[float], high: list[float]) -> Mesh:
    center, size = 0.5 * (np.array(low) + high), np.array(high) - low
    return CUBE_VERTICES / np.ptp(CUBE_VERTICES, axis=0) * size + center, CUBE_TRIANGLES.astype(
        np.int64
    )


def joined(*meshes: Mesh) -> Mesh:
    offsets = np.cumsum([0] + [len(vertices) for vertices, _ in meshes])
    return np.concatenate([v for v, _ in meshes]), np.concatenate(
        [t + n for (_, t), n in zip(meshes, offsets)]
    )


def crossing_boxes() -> Mesh:
    return joined(box([-1, -0.3, -0.3], [1, 0.3, 0.3]), box([-0.31, -0.9, -0.2], [0.29, 0.8, 0.25]))


def hollow_box() -> Mesh:
    """Its cavity is bounded by a box that faces inward."""
    vertices, triangles = box([-0.3, -0.2, -0.4], [0.5, 0.3, 0.4])
    return joined(box([-1, -0.5, -0.7], [1, 0.5, 0.7]), (vertices, triangles[:, ::-1]))


def knotted_tube() -> Mesh:
    """A tube around a limaçon, whose inner loop passes through the outer one: one part that crosses
    itself."""

    def place(u: Any, v: Any) -> Any:
        radius = 0.5 + np.cos(u) + 0.15 * np.cos(v)
        return np.stack([radius * np.cos(u), 0.15 * np.sin(v), radius * np.sin(u)], -1)

    vertices, triangles = grid_surface(80, 16, place)
    return vertices, triangles[:, ::-1]


MESHES = {"torus": torus, "sphere": open_sphere, "cross": crossing_boxes, "hollow": hollow_box}
VOLUMES = {"cross": 2 * 0.6 * 0.6 + 0.6 * 0.45 * 1.1, "hollow": 2 * 1 * 1.4 - 0.8 * 0.5 * 0.8}
PATTERNS = {"voronoi": 20, "radial": 7, "natural": 60}


@pytest.fixture(scope="module")
def mesh_file(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Mesh, str], Path]:
    folder = tmp_path_factory.mktemp("meshes")

    def write(mesh: Mesh, name: str) -> Path:
        path = folder / f"{name}.obj"
        lines = ["v %r %r %r" % tuple(vertex) for vertex in mesh[0].tolist()]
        lines += ["f %d %d %d" % tuple(triangle) for triangle in (mesh[1] + 1).tolist()]
        path.write_text("\n".join(lines))
        return path

    return write


@pytest.fixture(scope="module")
def broken(mesh_file: Callable[[Mesh, str], Path]) -> Callable[[str, str, bool], Pieces]:
    known: dict[tuple[str, str, bool], Pieces] = {}

    def make(mesh: str, pattern: str, exact: bool) -> Pieces:
        if (mesh, pattern, exact) not in known:
            path = mesh_file(MESHES[mesh](), mesh)
            known[mesh, pattern, exact] = break_mesh(
                path,
                Pattern.named(pattern, cells=PATTERNS[pattern], seed=3),
                exact=exact,
                voxels=40,
            )
        return known[mesh, pattern, exact]

    return make


def defects(triangles: np.ndarray) -> int:
    """How many directed edges have no opposite, or come twice."""
    edges = np.concatenate(
        [triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]
    ).astype(np.int64)
    key, opposite = edges[:, 0] << 32 | edges[:, 1], edges[:, 1] << 32 | edges[:, 0]
    return len(edges) - len(np.unique(key)) + len(np.setdiff1d(key, opposite))


def windings(piece: Piece, points: np.ndarray) -> np.ndarray:
    """How many times a piece's surface winds around each point."""
    a, b, c = (piece.vertices[piece.triangles[:, k]][None] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=2) for x in (a, b, c))
    up = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
    down = la * lb * lc + (a * b).sum(2) * lc + (b * c).sum(2) * la + (c * a).sum(2) * lb
    return np.round(np.arctan2(up, down).sum(axis=1) / (2 * np.pi)).astype(int)


def areas(piece: Piece) -> np.ndarray:
    corners = piece.vertices[piece.triangles]
    return 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )


def break_cross(cross_file: Path, out: Path) -> None:
    """Breaks the cross exactly into the cells of nine points."""
    cells = ["--pattern", "voronoi", "--cells", "9", "--exact"]
    assert main(["break", str(cross_file), *cells, "--out", str(out)]) == 0


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("mesh", MESHES)
def test_exact_pieces_are_closed_and_fit_without_gap_or_overlap(
    mesh: str, pattern: str, broken: Callable[..., Pieces]
) -> None:
    pieces = broken(mesh, pattern, True)
    # A fourth one of the torus is below a hundredth of the mean, and joins its neighbour.
    assert len(pieces.pieces) > 2
    assert pieces.volume_defect < 1e-9
    if mesh in VOLUMES:
        assert pieces.volume == pytest.approx(VOLUMES[mesh], rel=1e-12)
    assert [piece.name for piece in pieces.pieces] == [
        f"piece_{index:03}" for index in range(len(pieces.pieces))
    ]
    for piece in pieces.pieces:
        assert defects(piece.triangles) == 0
        assert piece.volume > 0.0
        # The coordinates measure the cracks: areas in them are areas in space.
        u, v = np.moveaxis(piece.coordinates.astype(np.float64), 2, 0)
        measured = 0.5 * (
            (u[:, 1] - u[:, 0]) * (v[:, 2] - v[:, 0]) - (u[:, 2] - u[:, 0]) * (v[:, 1] - v[:, 0])
        )
        assert np.abs(np.abs(measured) - areas(piece))[piece.inner].max() < 1e-5

    # Each point is in one piece or, with the whole's volume fraction, in none.
    points = np.concatenate([piece.vertices for piece in pieces.pieces])
    low, high = points.min(axis=0), points.max(axis=0)
    samples = low + (high - low) * np.random.default_rng(1).random((300, 3))
    depth = np.stack([windings(piece, samples) for piece in pieces.pieces])
    assert depth.min() == 0
    assert depth.sum(axis=0).max() == 1
    assert depth.sum() / 300 == pytest.approx(pieces.volume / np.prod(high - low), abs=0.09)


@pytest.mark.parametrize("size", [0.99, 1.01])
def test_drawn_cells_that_nearly_fit_cut_a_mesh_into_all_of_it(
    size: float, cross_file: Path, tmp_path: Path
) -> None:
    """Small gaps go to a neighbour, what two cells share to the first."""
    pattern, text, first = Pattern.named("voronoi", cells=12), "", 1
    for cell in range(len(pattern)):
        vertices, triangles = pattern.region_mesh(cell)
        middle = vertices.mean(axis=0)
        text += "".join(
            f"v {x!r} {y!r} {z!r}\n" for x, y, z in (middle + size * (vertices - middle)).tolist()
        )
        text += "".join(f"f {a} {b} {c}\n" for a, b, c in (triangles + first).tolist())
        first += len(vertices)
    drawn = tmp_path / "drawn.obj"
    drawn.write_text(text)
    pieces = break_mesh(cross_file, Pattern.named(str(drawn)), exact=True)
    assert len(pieces.pieces) > 3
    assert pieces.volume_defect < 1e-9
    for piece in pieces.pieces:
        assert defects(piece.triangles) == 0
        assert piece.volume > 0.0


def test_a_gap_around_a_cell_leaves_the_cell_what_it_is() -> None:
    """The gap is a shell: it goes to its neighbour without what it encloses."""
    from frangible.breaking.exact_cut import as_manifold

    def cutter(*meshes: Mesh) -> Any:
        vertices, triangles = joined(*meshes)
        return vertices, triangles.astype(np.uint32), np.zeros(len(triangles), np.uint32)

    whole, (corners, faces) = box([-1, -1, -1], [1, 1, 1]), box([-0.5, -0.5, -0.5], [0.5, 0.5, 0.5])
    around = cutter(whole, (corners, faces[:, ::-1]))
    inner = cutter(box([-0.49, -0.49, -0.49], [0.49, 0.49, 0.49]))
    vertices, triangles = whole
    body = labelled(as_manifold(vertices, triangles.astype(np.uint32)))
    parts = cut(body, [around, inner]).parts()
    volumes = [mesh_mass((part.vertices, part.triangles))["volume_m3"] for part in parts]
    assert volumes == pytest.approx([8.0 - 0.98**3, 0.98**3])


@pytest.mark.parametrize("mesh", MESHES)
def test_exact_contacts_are_the_cracks(mesh: str, broken: Callable[..., Pieces]) -> None:
    pieces = broken(mesh, "voronoi", True)
    cracks = np.array([(areas(piece) * piece.inner).sum() for piece in pieces.pieces])
    for contact in pieces.contacts:
        assert contact["a"] < contact["b"]
        assert math.hypot(*contact["normal"]) == pytest.approx(1.0)
        cracks[[contact["a"], contact["b"]]] -= contact["area_m2"]
    assert np.abs(cracks).max() < 1e-9


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("mesh", MESHES)
def test_grid_pieces_are_those_of_the_exact_path(
    mesh: str, pattern: str, broken: Callable[..., Pieces]
) -> None:
    on_grid, exact = broken(mesh, pattern, False), broken(mesh, pattern, True)
    assert on_grid.volume_defect < 0.02
    # A straight-sided hole is patched flat, the grid's by winding number.
    assert on_grid.volume == pytest.approx(exact.volume, rel=0.01)
    points = np.concatenate([piece.vertices for piece in on_grid.pieces])
    voxel = (np.ptp(points, axis=0).max() / 40) ** 3
    for piece in on_grid.pieces:
        assert defects(piece.triangles) == 0
        assert piece.inner.any()
        corners = piece.vertices[piece.triangles]
        enclosed = (
            np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
        )
        assert enclosed == pytest.approx(piece.volume, rel=0.15, abs=20 * voxel)
    # The large ones have the same place and volume.
    for piece in exact.pieces:
        if piece.volume > 0.05 * exact.volume:
            same = min(
                on_grid.pieces, key=lambda other: float(np.linalg.norm(other.center - piece.center))
            )
            assert same.volume == pytest.approx(piece.volume, rel=0.05)
    # Where pieces are of a few voxels, slivers join their neighbours and take their cracks with
    # them.
    if pattern != "natural":
        areas_of = [
            sum(contact["area_m2"] for contact in pieces.contacts) for pieces in (on_grid, exact)
        ]
        assert areas_of[0] == pytest.approx(areas_of[1], rel=0.06)


def test_the_report_says_how_a_mesh_was_closed(
    broken: Callable[..., Pieces], mesh_file: Callable[..., Path]
) -> None:
    assert broken("sphere", "voronoi", True).notes == [
        "2 holes closed by triangles between the rim's vertices"
    ]
    assert broken("cross", "voronoi", True).notes == [
        "2 parts that cross, touch or lie in one another made one"
    ]
    assert broken("torus", "voronoi", True).notes == broken("hollow", "voronoi", True).notes == []
    crossing = break_mesh(
        mesh_file(knotted_tube(), "knot"), Pattern.named("voronoi", cells=8), voxels=40
    )
    (note,) = crossing.notes
    assert "crosses itself" in note and "40 voxels" in note
    assert crossing.volume_defect < 1e-9
    assert all(defects(piece.triangles) == 0 for piece in crossing.pieces)


def test_without_a_point_the_blow_lands_on_the_surface(
    broken: Callable[..., Pieces], mesh_file: Callable[..., Path]
) -> None:
    assert broken("cross", "voronoi", True).at == pytest.approx([0.0, 0.8, 0.0])
    # The line through the middle of a torus meets nothing.
    assert broken("torus", "voronoi", True).at[1] == pytest.approx(0.4, abs=1e-3)
    slab = mesh_file(box([0, 0, 0], [4, 1, 2]), "slab")
    beside = break_mesh(slab, Pattern.named("radial", cells=6), normal=[3, 0, 0], exact=True)
    assert beside.at == pytest.approx([4.0, 0.5, 1.0])
    assert beside.normal == pytest.approx([1.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def cross_file(mesh_file: Callable[[Mesh, str], Path]) -> Path:
    return mesh_file(crossing_boxes(), "cross")


@pytest.mark.parametrize("ending", ["glb", "gltf"])
@pytest.mark.parametrize("exact", [["--grid"], ["--exact"]])
def test_gltf_has_a_node_for_each_piece(
    ending: str, exact: list[str], cross_file: Path, tmp_path: Path
) -> None:
    out = tmp_path / f"cross.{ending}"
    arguments = [
        "break",
        str(cross_file),
        "--pattern",
        "voronoi",
        "--cells",
        "9",
        "--voxels",
        "30",
        "--out",
        str(out),
        *exact,
    ]
    assert main(arguments) == 0
    report = khronos_report(out)
    assert objections(report["issues"]) == []
    facts = json.loads((tmp_path / "cross.json").read_text())
    if ending == "gltf":
        document = json.loads(out.read_text())
        assert [node["name"] for node in document["nodes"]] == [
            *(piece["name"] for piece in facts["pieces"]),
            "cross",
        ]
        assert [material["name"] for material in document["materials"]] == ["outer", "inner"]
        # The origin of a piece is its centre of mass.
        assert document["nodes"][1]["translation"] == pytest.approx(
            facts["pieces"][1]["center_m"], rel=1e-6
        )
    # The same again, to the last bit.
    before = out.read_bytes(), (tmp_path / "cross.json").read_bytes()
    assert main(arguments) == 0
    assert (out.read_bytes(), (tmp_path / "cross.json").read_bytes()) == before


@pytest.mark.parametrize("ending", ["usd", "usda", "usdc"])
def test_usd_has_a_mesh_for_each_piece(ending: str, cross_file: Path, tmp_path: Path) -> None:
    out = tmp_path / f"cross.{ending}"
    break_cross(cross_file, out)
    stage = Usd.Stage.Open(str(out))
    assert violations(stage) == []
    meshes = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    facts = json.loads((tmp_path / "cross.json").read_text())
    assert [str(mesh.GetPath()) for mesh in meshes] == [
        f"/cross/{piece['name']}" for piece in facts["pieces"]
    ]
    for mesh, piece in zip(meshes, facts["pieces"], strict=True):
        place = mesh.ComputeLocalToWorldTransform(0.0)
        points = np.array([place.Transform(point) for point in mesh.GetPointsAttr().Get()])
        assert points.min(axis=0) == pytest.approx(piece["low_m"], abs=1e-6)
        assert points.max(axis=0) == pytest.approx(piece["high_m"], abs=1e-6)
        subsets = UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets()
        assert [subset.GetPrim().GetName() for subset in subsets] == ["outside", "inside"]
        faces = np.concatenate([subset.GetIndicesAttr().Get() for subset in subsets])
        assert sorted(faces.tolist()) == list(range(len(mesh.GetFaceVertexCountsAttr().Get())))
        places = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get()
        assert len(places) == 3 * len(faces) and np.ptp(places, axis=0).min() > 0.0


def test_a_folder_has_an_obj_for_each_piece(
    cross_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "cross"
    command = [
        "break",
        str(cross_file),
        "--pattern",
        "voronoi",
        "--exact",
        "--json",
        "--out",
        f"{folder}/",
    ]
    assert main([*command, "--cells", "30"]) == 0
    assert main([*command, "--cells", "9"]) == 0
    summary = json.loads(capsys.readouterr().out.splitlines()[-1])
    facts = json.loads((folder / "pieces.json").read_text())
    assert summary["pieces"] == len(facts["pieces"]) and summary["volume_defect"] < 1e-9
    names = {f"{piece['name']}.obj" for piece in facts["pieces"]}
    assert {path.name for path in folder.iterdir()} == {*names, "materials.mtl", "pieces.json"}
    for piece in facts["pieces"]:
        info = frangible.mesh_info(folder / f"{piece['name']}.obj")
        assert info["watertight"]
        assert info["volume_m3"] == pytest.approx(piece["volume_m3"], rel=1e-12)
        text = (folder / f"{piece['name']}.obj").read_text()
        assert "usemtl inner" in text and "vt " in text
        # Neighbours know each other.
        for neighbour in piece["neighbours"]:
            (other,) = [other for other in facts["pieces"] if other["name"] == neighbour["name"]]
            (back,) = [again for again in other["neighbours"] if again["name"] == piece["name"]]
            assert back["area_m2"] == neighbour["area_m2"]
            assert back["normal"] == [-component for component in neighbour["normal"]]


def test_one_obj_holds_all_pieces(cross_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "all.obj"
    break_cross(cross_file, out)
    facts = json.loads((tmp_path / "all.json").read_text())
    objects = [line for line in out.read_text().splitlines() if line.startswith("o ")]
    assert objects == [f"o {piece['name']}" for piece in facts["pieces"]]
    vertices, _ = load_mesh(str(out))
    assert frangible.mesh_info(out)["volume_m3"] == pytest.approx(facts["volume_m3"], rel=1e-9)
    assert (tmp_path / "all.mtl").exists() and len(vertices) > 0


def test_a_missing_library_is_named_with_the_way_to_get_it(
    cross_file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("frangible.extras.find_spec", lambda _: None)
    arguments = [
        "break",
        str(cross_file),
        "--pattern",
        "voronoi",
        "--exact",
        "--out",
        str(tmp_path / "pieces.glb"),
    ]
    assert main(arguments) == 2
    assert "pip install 'frangible[exact]'" in capsys.readouterr().err


def test_a_part_that_joins_a_hollow_one_leaves_its_cavity() -> None:
    # A block with a cavity, and on one side of it a thin plate and a beam, all in one.
    block = Manifold.cube([3, 2, 2]).translate([-3, 0, 0]) - Manifold.cube([1, 1, 1]).translate(
        [-2, 0.5, 0.5]
    )
    plate = Manifold.cube([0.001, 0.5, 0.5]).translate([0, 0.2, 0.2])
    beam = Manifold.cube([2, 0.5, 0.5]).translate([0, 1.2, 1.2])
    body = block + plate + beam
    cells = [Manifold.cube([4, 4, 4]).translate([low, -1, -1]) for low in (-4, 0)]
    cutters = [(*arrays(cell), np.arange(12, dtype=np.uint32) // 2) for cell in cells]
    parts = cut(labelled(body), cutters, smallest=0.01).parts()
    volumes = sorted(mesh_mass((part.vertices, part.triangles))["volume_m3"] for part in parts)
    assert volumes == pytest.approx([0.5, 11.0 + 0.001 * 0.25], rel=1e-12)
