"""Every command answers programs: one line of JSON on stdout, errors too, with the exit status."""

import json
from pathlib import Path
from typing import Any

import pytest
from frangible import Recording
from frangible.cli import main, parser


def commands() -> dict[str, Any]:
    (action,) = (one for one in parser()._actions if one.dest == "==SUPPRESS==" and one.choices)
    return dict(action.choices)  # type: ignore[arg-type]


def answer(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, Any]:
    capsys.readouterr()
    try:
        status = main(arguments)
    except SystemExit as exit_:
        assert isinstance(exit_.code, int)
        status = exit_.code
    (line,) = capsys.readouterr().out.splitlines()
    return status, json.loads(line)


def test_every_command_has_the_option() -> None:
    for name, command in commands().items():
        assert "--json" in command._option_string_actions, name


def test_results_are_json(
    scripted: Recording, tmp_path: Path, tetrahedron: str, capsys: pytest.CaptureFixture[str]
) -> None:
    scripted.save(tmp_path / "slab.npz")
    (tmp_path / "t.obj").write_text(tetrahedron)
    cache, mesh = str(tmp_path / "slab.npz"), str(tmp_path / "t.obj")
    for arguments, key in (
        (["run", "wall", "--frames", "2", "--out", f"{tmp_path}/run.npz"], "shot"),
        (["scene", "wall"], "bodies"),
        (["scene", "wall", "--out", f"{tmp_path}/w.json"], "outputs"),
        (["break", mesh, "--pattern", "voronoi", "--out", f"{tmp_path}/p.obj"], "pieces"),
        (["plot", f"{tmp_path}/run.npz", "--out", f"{tmp_path}/e.svg"], "outputs"),
        (["film", cache, "--size", "32x32", "--out", f"{tmp_path}/f/"], "outputs"),
        (["render", cache, "--size", "32x32", "--out", f"{tmp_path}/p.png"], "outputs"),
        (["pattern", "voronoi", "--cells", "5"], "cells"),
        (["shots"], "wall"),
        (["info", cache], "frames"),
        (["schema"], "properties"),
    ):
        status, found = answer([*arguments, "--json"], capsys)
        assert status == 0 and key in found, (arguments, list(found)[:9])
    (picture,) = found_outputs(tmp_path, cache, capsys)
    assert picture["bytes"] == (tmp_path / "again.png").stat().st_size


def found_outputs(
    tmp_path: Path, cache: str, capsys: pytest.CaptureFixture[str]
) -> list[dict[str, Any]]:
    out = ["--out", f"{tmp_path}/again.png", "--size", "32x32", "--json"]
    outputs: list[dict[str, Any]] = answer(["render", cache, *out], capsys)[1]["outputs"]
    return outputs


@pytest.mark.parametrize(
    ("arguments", "status", "sentence"),
    [
        (["run", "wal", "--json"], 2, "did you mean 'wall'"),
        (["film", "no.npz", "--out", "a.mp4", "--json"], 2, "no.npz: no such file"),
        (["film", "no.npz", "--out", "a.avi", "--json"], 2, "must be one of .gif, .html, .mp4"),
        (["film", "no.npz", "--out", "a", "--json"], 2, "or a folder, which ends in /"),
        (["film", "no.npz", "--json"], 2, "--out"),
        (
            ["film", "a", "--out", "a/", "--first", "9", "--last", "3", "--json"],
            2,
            "at most --last",
        ),
        (
            ["render", "a.npz", "--out", "a.png", "--shutter", "400", "--json"],
            2,
            "0 to 360 degrees",
        ),
        (["render", __file__, "--out", "a.png", "--json"], 2, "is not a .npz file"),
        (["scene", "wall", "--toml", "--json"], 2, "not allowed with argument --json"),
        (["info", "no.obj", "--json"], 2, "no.obj: no such file"),
        (
            ["break", "no.obj", "--pattern", "voronoi", "--out", "a.glb", "--json"],
            2,
            "no such file",
        ),
    ],
)
def test_errors_are_json(
    arguments: list[str], status: int, sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    found_status, found = answer(arguments, capsys)
    assert found_status == status == found["status"]
    assert sentence in found["error"]


@pytest.mark.parametrize(
    ("python", "sentence"),
    [("", "needs Blender: `pip install bpy`"), ("/no/such", "/no/such: is no program")],
)
def test_a_renderer_that_is_not_there_is_an_error(
    python: str, sentence: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pxr")
    monkeypatch.setenv("BLENDER_PYTHON", python)
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr("frangible.io.blender.find_spec", lambda _: None)
    for out in ("a.png", "a.mp4", "a/"):
        command = ["render", "no.npz", "--out", out, "--renderer", "blender", "--json"]
        status, found = answer(command, capsys)
        assert status == 2 and sentence in found["error"]


@pytest.mark.parametrize("option", ["--frame", "--first", "--last"])
def test_a_frame_that_is_not_there_is_an_error(
    option: str, scripted: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scripted.save(tmp_path / "slab.npz")
    command = "render" if option == "--frame" else "film"
    out = f"{tmp_path}/a.png" if option == "--frame" else f"{tmp_path}/a/"
    arguments = [command, str(tmp_path / "slab.npz"), "--out", out, option, "7", "--json"]
    status, found = answer(arguments, capsys)
    assert (status, found["status"]) == (2, 2)
    assert found["error"] == f"frangible: {option}: 7, must be at most the last frame, 6"


def test_an_output_that_fails_is_told_beside_those_that_do_not(
    scripted: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    scripted.save(tmp_path / "slab.npz")
    monkeypatch.setattr("frangible.io.cache.write_npz", full)
    out = ["--out", f"{tmp_path}/a.npz", "--out", f"{tmp_path}/a.glb", "--json"]
    status, found = answer(["render", str(tmp_path / "slab.npz"), *out], capsys)
    assert (status, found["status"]) == (1, 1)
    assert "No space left on device" in found["outputs"][0]["error"]
    assert found["outputs"][1]["bytes"] > 0


def test_a_film_shows_some_frames(scripted: Recording, tmp_path: Path) -> None:
    scripted.save(tmp_path / "slab.npz")
    options = ["--first", "2", "--last", "4", "--size", "32x32", "--quiet"]
    assert main(["film", str(tmp_path / "slab.npz"), "--out", f"{tmp_path}/f/", *options]) == 0
    names = sorted(path.name for path in (tmp_path / "f").iterdir())
    assert names == [f"frame_000{frame}.png" for frame in (2, 3, 4)]
