"""Files of scenes: what their sentences quote, and those in Python."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import frangible
import pytest
from frangible import BuildError, Scene, World
from frangible.cli import main
from frangible.scenes import as_json
from test_scenes import a_scene

DOCS = Path(__file__).parents[2] / "docs"

TOML = """# A wall.
frames = 3
gravity = [0, "down", 0]

[materials.granite]
like = "concrete"

[[bodies]]
name = "ground"
motion = "static"
shape = { kind = "half-space" }

[[bodies]]
name = "wall"
position = [0, 1, 0]
material = "granit"
shape = { kind = "box", size = [2, 2] }
"""


def refusal(path: Path) -> str:
    with pytest.raises(BuildError) as caught:
        World.build(path, 1)
    return str(caught.value)


@pytest.mark.parametrize(
    ("gone", "words"),
    [
        ([], ["bodies[1].material", '(body "wall")', 'material = "granit"']),
        (["material"], ["gravity[1]", 'gravity = [0, "down", 0]']),
        (["material", "gravity"], ["bodies[1].shape.size", 'body "wall"', "size = [2, 2]"]),
        (["material", "gravity", "shape ="], ["bodies[0].shape: missing", "[[bodies]]"]),
        (
            ["material", "gravity", 'shape = { kind = "box'],
            ["bodies[1].shape: missing", "[[bodies]]"],
        ),
    ],
)
def test_sentences_quote_the_line_of_a_toml_file(
    gone: list[str], words: list[str], tmp_path: Path
) -> None:
    path = tmp_path / "wall.toml"
    kept = [line for line in TOML.splitlines() if not any(line.startswith(one) for one in gone)]
    path.write_text("\n".join(kept) + "\n")
    said = refusal(path)
    sentence, quoted = said.splitlines()
    assert sentence.startswith(f"{path}, line "), said
    number = int(re.findall(r"line (\d+)", sentence)[0])
    assert quoted == f"  {number} | {kept[number - 1]}"
    assert [word for word in words if word not in said] == [] and words[-1] in quoted, said


@pytest.mark.parametrize(
    ("text", "quoted"),
    [
        ("strenth = 3", "strenth = 3"),
        ('strength = 3\npattern.kind = "voronio"', 'pattern.kind = "voronio"'),
        ("strength = 3\n[bodies.breaking.pattern]\nkind = 'voronoi'\ncells = 0", "cells = 0"),
    ],
)
def test_tables_within_a_body_are_its_own(text: str, quoted: str, tmp_path: Path) -> None:
    path = tmp_path / "wall.toml"
    ground = '[[bodies]]\nmotion = "static"\nshape = { kind = "half-space" }\n'
    wall = '[[bodies]]\nshape = { kind = "box", size = [1, 1, 1] }\n[bodies.breaking]\n'
    path.write_text(f"{ground}{wall}{text}\n")
    said = refusal(path)
    assert "bodies[1].breaking" in said and said.endswith(f" | {quoted}"), said


def test_sentences_quote_the_line_of_a_json_file(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    scene = a_scene()
    scene["bodies"][1]["breaking"]["strenth"] = 3
    path.write_text(as_json(scene))
    said = refusal(path)
    assert "bodies[1].breaking.strenth" in said and 'body "wall"' in said
    number = int(re.findall(r"line (\d+):", said)[0])
    assert '"strenth": 3' in path.read_text().splitlines()[number - 1]
    assert said.splitlines()[1].startswith(f"  {number} | ")
    # Items of lists have lines of their own.
    scene = a_scene()
    scene["bodies"][3]["shape"]["parts"][1]["size"] = "x"
    path.write_text(json.dumps(scene, indent=1))
    said = refusal(path)
    number = int(re.findall(r"line (\d+):", said)[0])
    assert said.splitlines()[1] == f'  {number} |       "size": "x"'


def test_a_field_that_was_set_is_not_quoted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(a_scene(), indent=1))
    assert main(["run", str(path), "--set", "bodies.wall.density=-1"]) == 2
    assert "line" not in capsys.readouterr().err


def test_a_long_line_is_cut_around_the_field(tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    scene = a_scene()
    scene["bodies"][2]["shape"]["points"] = [[i, 2 * i, i * i] for i in range(200)]
    scene["bodies"][2]["density"] = "heavy"
    path.write_text("\n" + json.dumps(scene))
    sentence, quoted = refusal(path).splitlines()
    assert 'bodies[2].density: "heavy"' in sentence
    assert len(quoted) < 120 and '"density": "heavy"' in quoted and quoted.count("...") == 2


def test_a_python_file_is_a_scene(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "sizes.py").write_text("SIZE = [1, 1, 1]\n")
    path = tmp_path / "scene.py"
    texts = [
        "scene = Scene([Body(Box(SIZE), name='a')], frames=2)",
        "scene = {'frames': 2, 'bodies': [{'name': 'a', 'shape': {'kind': 'box', 'size': SIZE}}]}",
        "def scene():\n    return Scene([Body(Box(SIZE), name='a')], frames=2)",
    ]
    hashes = set()
    for text in texts:
        path.write_text(f"from frangible import Body, Box, Scene\nfrom sizes import SIZE\n{text}\n")
        assert main(["run", str(path), "--json", "--quiet", "--threads", "1"]) == 0
        hashes.add(json.loads(capsys.readouterr().out)["state_hash"])
        assert Scene.load(path).frames == 2
    assert len(hashes) == 1
    assert str(tmp_path) not in sys.path


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "x = 1\nscene = 1 / 0\n",
            ["line 2: ZeroDivisionError: division by zero", "2 | scene = 1"],
        ),
        ("x = 1\nscene = = 2\n", ["line 2: invalid syntax, must be Python", "  2 | scene = = 2"]),
        ("x = 1\n", ["defines no scene, must define 'scene'"]),
        ("scene = 3\n", ["3, must be an object with the fields of a scene"]),
        ("scene = {'bodies': []}\n", ["bodies: [], must have one at least"]),
        (
            "from frangible import *\n\nscene = Scene.from_dict({'bodys': []})\n",
            ["line 3: bodys: unknown field (did you mean 'bodies'?)", "3 | scene = Scene.from"],
        ),
    ],
)
def test_what_a_python_file_does_wrong_is_named(
    text: str, words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "scene.py"
    path.write_text(text)
    assert main(["run", str(path), "--quiet"]) == 2
    said = capsys.readouterr().err
    assert [word for word in words if word not in said] == [], said
    assert "Traceback" not in said and len(said.splitlines()) <= 2


def test_the_python_of_the_docs_runs_and_mypy_checks_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    page = (DOCS / "scenes_in_python.md").read_text(encoding="utf-8")
    whole, function = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    Path("whole.py").write_text(whole)
    exec(compile(whole, "whole.py", "exec"), {})
    assert Path("wall.npz").stat().st_size > 0
    Path("scene.py").write_text(function)
    assert frangible.run("./scene.py", threads=1).frames == 60
    wrong = "from frangible import Body, Box, Scene\n"
    wrong += "Scene([Body(Box([1, 1, 1]), look='glas')], frames='x')\n"
    Path("wrong.py").write_text(wrong)

    # An installed package is found by itself.
    package = str(Path(frangible.__file__).parents[1])
    place = {} if "site-packages" in package else {"MYPYPATH": package}
    command = [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent"]
    checked = subprocess.run(
        [*command, "whole.py", "scene.py", "wrong.py"],
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, **place},
    )
    errors = [line for line in checked.stdout.splitlines() if ": error: " in line]
    assert [line.partition(":")[0] for line in errors] == ["wrong.py"] * 2, checked.stdout
    assert 'Argument "look"' in errors[0] and 'Argument "frames"' in errors[1]
