"""Commands of the pages about pictures, files and the command line run as they stand."""

import json
import shlex
from pathlib import Path

import pytest
from frangible.cli import main
from test_docs_of_scenes import blocks
from test_first_ten_minutes import ARCH


def run(command: str) -> int:
    words = shlex.split(command, comments=True)
    assert words[0] == "frangible"
    # Small pictures take less time.
    if words[1] == "film" and "--size" not in words:
        words += ["--size", "64x36"]
    return main(words[1:])


def test_films_are_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (block,) = blocks("docs/films.md", "sh")
    for command in block.strip().splitlines():
        assert run(command) == 0, command
    found = {str(path) for path in Path("out").rglob("*") if path.is_file()}
    blurred = {f"out/blurred/frame_000{frame}.png" for frame in range(3, 8)}
    assert found == {"out/wall.npz", "out/wall.mp4", "out/7.png", *blurred}


def test_stages_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pxr")
    monkeypatch.chdir(tmp_path)
    written = [block for block in blocks("docs/usd.md", "sh") if "geometry" in block]
    for command in written[0].strip().splitlines():
        assert run(f"{command.partition('#')[0]} --quiet") == 0, command
    names = sorted(path.name for path in Path("out").iterdir())
    assert names == ["set.geometry.usdc", "set.usdc", "set.usdz"]


def test_pieces_for_other_simulators_are_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("manifold3d")
    monkeypatch.chdir(tmp_path)
    Path("your.obj").write_text(ARCH)
    (block,) = blocks("docs/breaking_meshes.md", "sh")
    for command in block.strip().splitlines():
        assert run(command) == 0, command
    assert Path("out/pieces.xml").is_file() and Path("out/pieces.urdf").is_file()


def test_commands_for_programs_answer_in_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    programs, shells = blocks("docs/command_line.md", "sh")
    for command in programs.strip().splitlines():
        capsys.readouterr()
        assert run(command) == 0, command
        json.loads(capsys.readouterr().out)
    (_, error) = blocks("docs/command_line.md", "json")
    assert main(["film", "no.npz", "--out", "a.mp4", "--json"]) == 2
    assert json.loads(capsys.readouterr().out) == json.loads(error)
    pytest.importorskip("shtab")
    for command in shells.strip().splitlines():
        assert run(command.partition(">")[0]) == 0, command
