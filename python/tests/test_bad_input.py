"""Bad input is answered with one sentence that names what is wrong, before anything is simulated."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from frangible import BuildError, World, mesh_info, shot_scene
from frangible.cli import main


@pytest.fixture
def complain(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Runs the command, which must end with status 2, and answers with its one line on stderr."""

    def run(*arguments: object) -> str:
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as exit:
            status = exit.code
        captured = capsys.readouterr()
        assert status == 2
        assert captured.out == ""
        (line,) = captured.err.splitlines()
        return line

    return run


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "wal"], ["wal", "wall"]),
        (["run", "wall", "--frames", "0"], ["--frames", "'0'", "> 0"]),
        (["run", "wall", "--frames", "-3"], ["--frames", "'-3'", "> 0"]),
        (["run", "wall", "--frames", "two"], ["--frames", "'two'"]),
        (["run", "wall", "--fps", "0"], ["--fps", "'0'", "> 0"]),
        (["run", "wall", "--fps", "nan"], ["--fps", "'nan'", "> 0"]),
        (["run", "wall", "--fps", "inf"], ["--fps", "'inf'", "> 0"]),
        (["run", "wall", "--threads", "-1"], ["--threads", "'-1'", ">= 0"]),
        (["run", "wall", "--threads", "99999"], ["--threads", "'99999'", "<= 4096"]),
        (["run", "wall", "--seed", "x"], ["--seed", "'x'", ">= 0"]),
        (["run", "wall", "--seed", str(2**64)], ["--seed", str(2**64), str(2**64 - 1)]),
        (["run", "wall", "--method", "magic"], ["method", "magic", "paper"]),
        (["run", "wall", "--out", "wall.fbx"], ["wall.fbx", "'.fbx'", ".usdc"]),
        (["run", "wall", "--out", "no/such/wall.glb"], ["no/such/wall.glb", "'no/such'", "does not exist"]),
        (["run", "wall", "--frames", "3", "--frame", "4", "--out", "wall.png"], ["--frame", "4", "3"]),
        (["run", "wall", "--frame", "4"], ["--frame", ".png"]),
        (["run"], ["SHOT"]),
        ([], ["COMMAND"]),
        (["run", "wall", "--unknown"], ["--unknown"]),
        (["info", "no/such.obj"], ["no/such.obj", "no such file"]),
    ],
)
def test_arguments(arguments: list[str], words: list[str], complain: Callable[..., str]) -> None:
    line = complain(*arguments)
    assert [word for word in words if word not in line] == [], line


MESHES = {
    "missing.obj": (None, ["missing.obj"]),
    "empty.obj": ("", ["empty.obj"]),
    "noise.stl": ("this is no mesh", ["noise.stl"]),
    "flat.obj": ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ["flat.obj", "volume"]),
    "nan.obj": ("v 0 0 0\nv 1 0 0\nv 0 nan 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n", ["nan.obj", "finite"]),
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


@pytest.mark.parametrize("name", ["cache.npz", "cache.usda", "cache.usdc"])
def test_caches(name: str, complain: Callable[..., str], tmp_path: Path) -> None:
    (tmp_path / name).write_text("not a cache")
    assert name in complain("info", tmp_path / name)
