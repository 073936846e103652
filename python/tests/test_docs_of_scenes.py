"""Scenes, stages and commands of the documentation do what it says."""

import re
import shlex
import tomllib
from pathlib import Path
from typing import Any

import frangible
import pytest
from frangible import Scene, World
from frangible.cli import main
from test_first_ten_minutes import ARCH

ROOT = Path(__file__).resolve().parents[2]


def blocks(page: str, language: str) -> list[str]:
    found = re.findall(
        rf"```{language}\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL
    )
    assert found, page
    return found


def test_the_scene_of_the_readme_breaks(tmp_path: Path) -> None:
    (text,) = blocks("README.md", "toml")
    assert sum(bool(line.strip()) for line in text.splitlines()) <= 15
    path = tmp_path / "scene.toml"
    path.write_text(text)
    # The same in Python.
    (script,) = (block for block in blocks("README.md", "python") if "Scene(" in block)
    names: dict[str, object] = {}
    exec(script.partition("frangible.run(")[0], names)
    assert names["scene"] == Scene.load(path)
    recording = frangible.run(path, frames=6, threads=1)
    broken = [report for report in recording.reports if report["fractures"]]
    assert len(broken) == 1
    pieces = [body for body in recording.bodies if body.parent is not None]
    assert len(pieces) == pytest.approx(60, rel=0.1)
    assert {body.look for body in pieces} == {"concrete"}


def test_the_film_of_the_readme_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("embreex")
    monkeypatch.chdir(tmp_path)
    Path("scene.toml").write_text(blocks("README.md", "toml")[0])
    (command,) = (
        line
        for block in blocks("README.md", "sh")
        for line in block.splitlines()
        if "run scene.toml" in line
    )
    words = shlex.split(command.replace("--frames 30", "--frames 2"), comments=True)
    assert main([*words[1:], "--quiet", "--threads", "1"]) == 0
    assert Path("film.gif").stat().st_size > 0


def test_what_waits_in_the_docs_does(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(blocks("docs/direction.md", "toml")[0])
    recording = frangible.run(path, frames=20, threads=1)
    vase, ball = recording.bodies[:2]
    assert (ball.positions[:11] == ball.positions[0]).all()
    assert (ball.positions[11] != ball.positions[0]).any()
    (broken,) = (report for report in recording.reports if report["fractures"])
    # It flies for 0.7 m, at 9 m/s.
    assert broken["frame"] == vase.death_frame == 13
    assert (vase.positions == vase.positions[0]).all()


def test_what_the_docs_throw_breaks_the_wall(monkeypatch: pytest.MonkeyPatch) -> None:
    script, by_hand = blocks("docs/direction.md", "python")
    monkeypatch.chdir(ROOT)
    names: dict[str, Any] = {}
    exec(script, names)
    world = names["world"]
    assert names["thrown"] not in world.ids
    assert len(world.ids) > 10

    names = {}
    exec(by_hand, names)
    assert names["work"] > 0
    assert len(names["pieces"]) > 2


def test_materials_of_the_docs_build() -> None:
    (body,) = blocks("docs/materials.md", "json")
    World.build(f'{{"bodies": [{body}]}}', 1)
    text, look = blocks("docs/materials.md", "toml")
    scene = tomllib.loads(text.replace('look = "stone"\n', "") + look)
    assert Scene.from_dict(scene).materials is not None
    (mass,) = World.build(scene, 1).masses
    assert mass == pytest.approx(2700)


def test_the_stage_of_the_docs_is_read(tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    (text,) = blocks("docs/usd.md", "usda")
    points = "int[] faceVertexCounts = [3, 3, 3, 3]\n"
    points += "int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]\n"
    points += "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]\n"
    path = tmp_path / "stage.usda"
    path.write_text(f"#usda 1.0\n(\n metersPerUnit = 1\n)\n{text.replace('{', '{' + points, 1)}")
    (wall,) = Scene.load(path).bodies
    assert wall.name == "/Wall" and wall.material == "concrete"
    assert wall.breaking is not None and wall.breaking.pieces == 60


def test_commands_of_the_docs_are_understood(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As scenes, with a small mesh in place of the one that is named."""
    monkeypatch.chdir(tmp_path)
    Path("suzanne.obj").write_text(ARCH)
    commands = blocks("docs/one_mesh.md", "sh")[0].replace("\\\n", " ").splitlines()
    for command in commands:
        words = shlex.split(command, comments=True)
        assert words[:2] == ["frangible", "run"]
        without_output = words[2 : words.index("--out")]
        assert main(["scene", *without_output]) == 0, command
    assert '"name": "ball"' in capsys.readouterr().out


def test_the_python_of_the_caches_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    frangible.run("pane", frames=6).save("pane.npz")
    for text in blocks("docs/caches.md", "python"):
        exec(compile(text, "docs/caches.md", "exec"), {})
    said = capsys.readouterr().out
    found = re.fullmatch(r"a pane of \[.*\] m, with (.*) m\^2 of cracks\n", said)
    assert found is not None and float(found[1]) > 0.01
