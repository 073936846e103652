"""Bad input is answered with one sentence that names what is wrong, before anything is
simulated."""

import json
import math
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import frangible
import numpy as np
import pytest
from frangible import BuildError, Recording, World, shot_frames, shot_scene
from frangible.cli import main

HERE = Path(__file__).parent


@pytest.fixture
def complain(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Runs the command, which must end with status 2, and answers with its sentence on stderr."""

    def run(*arguments: object) -> str:
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as exit:
            status = exit.code
        captured = capsys.readouterr()
        assert status == 2
        assert captured.out == ""
        # A busy machine may have said what it is at.
        (line,) = (said for said in captured.err.splitlines() if not said.endswith(" ..."))
        return line

    return run


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "wal-ball"], ["wal-ball", "(did you mean 'wall-ball'?)"]),
        (["rnu", "wall"], ["'rnu'", "did you mean 'run'?"]),
        (["run", "wall", "--frmes", "3"], ["--frmes", "did you mean '--frames'?"]),
        (["run", "scene.json"], ["scene.json", "no such file"]),
        (["run", "./wall"], ["./wall", "no such file"]),
        (["verify", "hea"], ["hea", "(did you mean 'heap'?)"]),
        (["pattern", "voronio"], ["voronio", "(did you mean 'voronoi'?)"]),
        (["run", "wall", "--frames", "0"], ["--frames", "'0'", "from 1 to"]),
        (["run", "wall", "--frames", "-3"], ["--frames", "'-3'", "from 1 to"]),
        (["run", "wall", "--frames", "two"], ["--frames", "'two'"]),
        (["run", "wall", "--fps", "0"], ["--fps", "'0'", "> 0"]),
        (["run", "wall", "--fps", "nan"], ["--fps", "'nan'", "> 0"]),
        (["run", "wall", "--fps", "inf"], ["--fps", "'inf'", "> 0"]),
        (["run", "wall", "--threads", "-1"], ["--threads", "'-1'", "from 0 to"]),
        (["run", "wall", "--threads", "99999"], ["--threads", "'99999'", "to 4096"]),
        (["run", "wall", "--seed", "x"], ["--seed", "'x'", "from 0 to"]),
        (["run", "wall", "--seed", str(2**64)], ["--seed", str(2**64), str(2**64 - 1)]),
        (["run", "wall", "--method", "magic"], ["method", "magic", "frame-rate, paper"]),
        (["run", "wall", "--out", "wall.fbx"], ["wall.fbx", "'.fbx'", ".usdc"]),
        (
            ["run", "wall", "--out", f"{__file__}/such/wall.glb"],
            [f"{__file__}/such/wall.glb", "is no folder"],
        ),
        (
            ["run", "wall", "--frames", "3", "--frame", "4", "--out", "wall.png"],
            ["--frame", "4", "3"],
        ),
        (["run", "wall", "--frame", "4"], ["--frame", ".png"]),
        (["run"], ["SHOT", "see frangible run -h"]),
        (["run", "wall", "--frames", "9" * 20], ["--frames", "9" * 20, "to 4294967295"]),
        (["run", "wall", "--size", "-5x20"], ["--size", "must be --size WxH"]),
        (["run", __file__], [__file__]),
        (["run", "wall", "--out", ""], ["--out: ''", "must be the name of a file"]),
        (["run", "wall", "wall"], ["wall", "see frangible run -h"]),
        (["run", "wall", "--camera", "fti", "--out", "a.png"], ["fti", "no such file", "'fit'"]),
        (["run", "wall", "--pieces", "-1"], ["--pieces", "'-1'", "from 0 to"]),
        (["run", "wall", "--set", "bodies.wal.density=3"], ["wal", "(did you mean 'wall'?)"]),
        (["run", "wall", "--set", "bodies.wall.densty=3"], ["densty", "(did you mean 'density'?)"]),
        (["run", "wall", "--set", "bodies.wall.density=-3"], ["density", "-3", "kg/m^3"]),
        (["run", "wall", "--set", "bodies.wall.density=20kg"], ["density", '"20kg"', "finite"]),
        (["run", "wall", "--set", "bodies.wall.density"], ["must be PATH=VALUE"]),
        (["run", "wall", "--set", "gravity=9.81"], ["gravity", "9.81", "list of 3 numbers"]),
        (["run", "wall", "--set", "frames=2.5"], ["frames", "2.5", "whole number"]),
        (
            ["render", __file__, "--out", "a.png"],
            [__file__, "is not a .npz file", "--out test_bad"],
        ),
        (["render", "no/such.npz", "--out", "a.png"], ["no/such.npz", "no such file"]),
        (["scene", "wal"], ["wal", "(did you mean 'wall'?)"]),
        (["scene", "impact"], ["impact", "--mesh FILE"]),
        (["info", "a.obj", "b.obj"], ["b.obj", "see frangible info -h"]),
        (
            ["break", "a.obj", "--pattern", "voronoi", "--out", "p.glb", "--at", "1,2"],
            ["--at", "X"],
        ),
        (
            ["break", "a.obj", "--pattern", "voronoi", "--out", "p.glb", "--thickness", "1cm"],
            ["'1cm'"],
        ),
        (["run", "wall", "--unknown"], ["--unknown"]),
        (["info", "no/such.obj"], ["no/such.obj", "no such file"]),
        (["info", str(HERE)], [str(HERE), "is a folder"]),
        (["plot", "no/such.npz", "--out", "energy.png"], ["no/such.npz", "no such file"]),
        (["plot", str(HERE), "--out", "energy.png"], [str(HERE), "is a folder"]),
        (["plot", __file__, "--out", "energy.png"], [__file__, "is not a .npz file"]),
        (["plot", __file__, "--out", "energy.glb"], ["energy.glb", ".pdf, .png, .svg"]),
        (
            ["plot", __file__, "--out", f"{__file__}/energy.png"],
            [f"{__file__}/energy.png", "is no folder"],
        ),
        (["plot", __file__], ["--out"]),
        (
            ["break", "no/such.obj", "--pattern", "voronoi", "--out", "p.glb"],
            ["no/such.obj", "no such file"],
        ),
        (
            ["break", "no.obj", "--pattern", "glass", "--out", "p.glb"],
            ["glass", "radial", "voronoi", "file"],
        ),
        (["break", "no.obj", "--pattern", "no/such.json", "--out", "p.glb"], ["no/such.json"]),
        (
            ["break", "no.obj", "--pattern", "voronoi", "--out", "p.fbx"],
            ["p.fbx", ".glb", ".usdc", "folder"],
        ),
        (
            ["break", "no.obj", "--pattern", "voronoi", "--out", f"{__file__}/p.glb"],
            ["is no folder"],
        ),
        (
            ["break", "no.obj", "--pattern", "voronoi", "--out", str(HERE)],
            [str(HERE), "must be new, empty"],
        ),
        (
            ["break", "no.obj", "--pattern", "voronoi", "--cells", "0", "--out", "p.glb"],
            ["--cells", "from 1 to"],
        ),
        (
            ["break", "no.obj", "--pattern", "voronoi", "--at", "0", "x", "0", "--out", "p.glb"],
            ["--at", "'x'", "finite"],
        ),
        (
            ["break", "no.obj", "--pattern", "voronoi", "--voxels", "9999", "--out", "p.glb"],
            ["--voxels", "1024"],
        ),
        (["break", "no.obj", "--out", "p.glb"], ["--pattern"]),
    ],
)
def test_arguments(arguments: list[str], words: list[str], complain: Callable[..., str]) -> None:
    line = complain(*arguments)
    assert [word for word in words if word not in line] == [], line


def test_what_is_no_scene_is_told_apart_from_an_unknown_shot(
    complain: Callable[..., str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("notes.txt").write_text("dear")
    Path("folder").mkdir()
    rule = "must end in .json, .toml, .py, .usd, .usda, .usdc or .usdz, or be the name of a shot"
    assert complain("run", "notes.txt") == f"frangible: notes.txt: is no scene file, {rule}"
    assert complain("run", "folder") == f"frangible: folder: is a folder, {rule}"


MESHES = {
    "missing.obj": (None, ["missing.obj"]),
    "empty.obj": ("", ["empty.obj"]),
    "noise.stl": ("this is no mesh", ["noise.stl"]),
    "flat.obj": ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ["flat.obj", "volume"]),
    "nan.obj": (
        "v 0 0 0\nv 1 0 0\nv 0 nan 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n",
        ["nan.obj", "finite"],
    ),
    "index.obj": ("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 9\n", ["index.obj"]),
    "unknown.xyz": ("0 0 0\n", ["unknown.xyz"]),
}


@pytest.mark.parametrize("name", MESHES)
def test_meshes(name: str, complain: Callable[..., str], tmp_path: Path) -> None:
    content, words = MESHES[name]
    path = tmp_path / name
    if content is not None:
        path.write_text(content)
    line = complain("run", "impact", "--mesh", path)
    assert [word for word in words if word not in line] == [], line
    # A flat mesh can still be described.
    if name != "flat.obj":
        assert complain("info", path) == line


def test_other_arrays_are_no_cache(complain: Callable[..., str], tmp_path: Path) -> None:
    np.savez(tmp_path / "arrays.npz", positions=np.zeros((3, 3)))
    assert "is not a Frangible cache" in complain(
        "plot", tmp_path / "arrays.npz", "--out", tmp_path / "energy.png"
    )


@pytest.mark.parametrize("frames", [0, -1])
def test_a_run_without_frames_says_so(frames: int) -> None:
    with pytest.raises(ValueError, match=f"^frames: {frames}, must be > 0$"):
        frangible.run("wall", frames=frames)
    with pytest.raises(ValueError, match=f"^frames: {frames}, must be > 0$"):
        Recording.record(World.build(shot_scene("incline")), frames)


@pytest.mark.parametrize("fps", [math.nan, math.inf, 0.0, -30.0])
def test_a_frame_rate_that_is_none_says_so(fps: float) -> None:
    for ask in (shot_scene, shot_frames):
        with pytest.raises(BuildError, match=r"^fps: .*, must be a number > 0$"):
            ask("wall", fps=fps)


@pytest.mark.parametrize("name", ["cache.npz", "cache.usda", "cache.usdc"])
def test_caches(name: str, complain: Callable[..., str], tmp_path: Path) -> None:
    (tmp_path / name).write_text("not a cache")
    assert name in complain("info", tmp_path / name)


def test_a_mesh_to_break_must_enclose_something(
    complain: Callable[..., str], tmp_path: Path
) -> None:
    flat = tmp_path / "flat.obj"
    flat.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    line = complain("break", flat, "--pattern", "voronoi", "--out", tmp_path / "flat.glb")
    assert "flat.obj" in line and "volume" in line


def test_a_mesh_is_not_written_over(complain: Callable[..., str], tmp_path: Path) -> None:
    mesh = tmp_path / "tetrahedron.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    before = mesh.read_text()
    line = complain("break", mesh, "--pattern", "voronoi", "--out", mesh)
    assert "--out" in line and str(mesh) in line and "must be another file" in line
    assert mesh.read_text() == before


def test_a_blow_must_come_from_somewhere(complain: Callable[..., str], tmp_path: Path) -> None:
    mesh = tmp_path / "tetrahedron.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    line = complain(
        "break", mesh, "--pattern", "voronoi", "--normal", 0, 0, 0, "--out", tmp_path / "pieces.glb"
    )
    assert "normal" in line and "zero" in line


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["break", "MESH", "--pieces", "1"], "--pieces: 1, must be from 2 to 10000"),
        (["break", "MESH", "--inside", ""], "argument --inside: '', must be a name"),
        (
            ["break", "MESH", "--voxels", "0"],
            "argument --voxels: '0', must be a whole number from 1 to 1024",
        ),
        (["break", "MESH.xyz"], "must end in one of .obj, .ply, .stl, .gltf, .glb, .usd, "),
    ],
)
def test_break_keeps_the_rules_of_run(
    tetrahedron: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    sentence: str,
) -> None:
    for name in ("a.obj", "a.xyz"):
        (tmp_path / name).write_text(tetrahedron)
    mesh = str(tmp_path / "a")
    chosen = [mesh + word[4:] if word.startswith("MESH.") else word for word in arguments]
    chosen = [f"{mesh}.obj" if word == "MESH" else word for word in chosen]
    with suppress(SystemExit):
        assert main([*chosen, "--pattern", "voronoi", "--out", str(tmp_path / "o.glb")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert sentence in line


def test_a_blow_beside_the_mesh_and_one_piece_are_named(
    tetrahedron: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mesh = tmp_path / "a.obj"
    mesh.write_text(tetrahedron)
    way = ["--pattern", "voronoi", "--quiet", "--out", str(tmp_path / "o.glb")]
    assert main(["break", str(mesh), *way, "--at", "100", "100", "100"]) == 0
    said = capsys.readouterr()
    assert "the blow at (100, 100, 100) lies 171 m outside of the mesh's bounding box" in said.out
    assert "no crack of the pattern passes through the mesh" in said.out
    assert "\n1 piece of a in" in said.out and said.err == ""


@pytest.mark.parametrize(
    ("field", "value", "rule"),
    [
        ("bodies.a.breaking.strength", "1e-200", "must be between 1e-15 and 1e12 N s"),
        ("bodies.a.linear_velocity", "[1e6, 0, 0]", "must be three numbers from -1e5 to 1e5 m/s"),
        (
            "bodies.a.angular_velocity",
            "[0, 1e5, 0]",
            "must be three numbers from -1e4 to 1e4 rad/s",
        ),
        ("gravity", "[0, -1e30, 0]", "must be three numbers from -1e4 to 1e4 m/s^2"),
        ("frames", "0", "must be from 1 to 4294967295"),
        ("frames", "-3", "must be a whole number from 1 to 4294967295"),
        ("bodies.a.breaking.pattern.spokes", "100000", "spokes: 100000, must be from 3 to 10000"),
    ],
)
def test_what_the_engine_cannot_hold_is_refused_by_its_field(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], field: str, value: str, rule: str
) -> None:
    breaking = {"strength": 1.0, "pattern": {"kind": "radial"}}
    body = {"name": "a", "shape": {"kind": "sphere", "radius": 1.0}, "breaking": breaking}
    scene = tmp_path / "s.json"
    scene.write_text(json.dumps({"bodies": [body]}))
    assert main(["run", str(scene), "--quiet", "--set", f"{field}={value}"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert field.rpartition(".")[2] in line and rule in line


def test_usd_errors_name_no_place_in_its_code(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.usdz"
    path.write_bytes(b"PK damaged" * 20)
    assert main(["info", str(path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "is not a readable USD file" in line and "pxr" not in line


def test_files_in_the_way_of_old_systems_are_read(
    tetrahedron: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mesh = tmp_path / "a.obj"
    mesh.write_bytes(tetrahedron.replace("\n", "\r").encode())
    assert main(["info", str(mesh)]) == 0
    assert "volume_m3       0.166667" in capsys.readouterr().out
    # A number with two hundred digits is shown with a few.
    mesh.write_text(tetrahedron.replace("v 1", "v 1" + "0" * 200))
    assert main(["info", str(mesh)]) == 2
    assert "vertex 1 is (1e200, 0, 0), coordinates must be" in capsys.readouterr().err


def test_triangles_of_a_scene_are_named_with_their_body(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    shape = {"kind": "triangles", "positions": corners, "triangles": [[0, 1, 7]]}
    scene = tmp_path / "s.json"
    scene.write_text(json.dumps({"bodies": [{"name": "wing", "shape": shape}]}))
    assert main(["run", str(scene), "--quiet"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    sentence = 'bodies[0].shape: triangle 0 refers to vertex 7, must be 0 to 2 (body "wing")'
    assert line == f"frangible: {sentence}"


def test_voxels_are_checked_where_none_are_needed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shape = {"kind": "sphere", "radius": 1.0, "resolution": {"voxels": [0, 1, 1]}}
    breaking = {"strength": 1.0, "pattern": {"kind": "radial"}}
    scene = tmp_path / "s.json"
    scene.write_text(json.dumps({"bodies": [{"shape": shape, "breaking": breaking}]}))
    assert main(["run", str(scene), "--quiet"]) == 2
    assert "bodies[0].shape.resolution.voxels: 0, must be from 1 to" in capsys.readouterr().err
