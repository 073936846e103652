"""Scenes of one's own: files, dictionaries, fields set by hand, and what is said of what does not
fit."""

import copy
import json
import math
import os
import random
import re
import signal
import subprocess
import sys
import threading
import time
import tomllib
from pathlib import Path
from typing import Any

import frangible
import numpy as np
import pytest
from frangible import BuildError, World
from frangible.cli import main
from frangible.cli.scene_page import scene_page
from frangible.io.toml_text import as_toml

DOCS = Path(__file__).parents[2] / "docs"
SCENES = sorted(path for path in (DOCS / "scenes").iterdir() if path.suffix in (".json", ".toml"))

GROUND = {"name": "ground", "motion": "static", "shape": {"kind": "half-space"}}


def a_scene() -> dict[str, Any]:
    """One body of nearly everything."""
    return {
        "name": "all",
        "gravity": [0, -9.81, 0],
        "frames_per_second": 30.0,
        "bodies": [
            copy.deepcopy(GROUND),
            {
                "name": "wall",
                "shape": {"kind": "box", "size": [2, 2, 0.3], "resolution": {"voxels": None}},
                "position": [0, 1, 0],
                "orientation": [0, 0, 0, 1],
                "density": 2400,
                "look": "concrete",
                "breaking": {
                    "strength": {
                        "tensile_strength": 3e6,
                        "youngs_modulus": 30e9,
                        "fracture_energy": 100,
                    },
                    "pattern": {"kind": "voronoi", "cells": 12, "grading": [0, 0, 0], "seed": 3},
                    "generations": 1,
                },
            },
            {
                "name": "hull",
                "shape": {"kind": "hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]},
                "position": [5, 1, 0],
            },
            {
                "name": "stool",
                "position": [-5, 1, 0],
                "shape": {
                    "kind": "compound",
                    "parts": [
                        {"kind": "box", "size": [1, 0.1, 1]},
                        {"kind": "box", "size": [0.1, 1, 0.1]},
                    ],
                },
            },
            {
                "name": "beam",
                "position": [0, 5, 0],
                "shape": {"kind": "box", "size": [2, 0.2, 0.2]},
                "bonds": {
                    "pattern": {"kind": "slices", "cells": 4},
                    "tensile_strength": 1e6,
                    "shear_strength": 1e6,
                    "anchors": [{"low": [-2, 4, -1], "high": [-0.5, 6, 1]}],
                },
            },
        ],
    }


def refusal(scene: Any) -> str:
    with pytest.raises(BuildError) as caught:
        World.build(scene, 1)
    return str(caught.value)


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.name)
def test_the_scenes_of_the_docs_run_and_break(path: Path) -> None:
    recording = frangible.run(path, threads=1)
    assert any(report["fractures"] for report in recording.reports)


def test_the_page_is_what_the_descriptions_say() -> None:
    stored = (DOCS / "scene_format.md").read_text(encoding="utf-8")
    assert stored == scene_page(frangible.scene_schema()), (
        "write it anew: frangible schema --markdown > docs/scene_format.md"
    )


def test_the_package_holds_the_schema_that_the_descriptions_make() -> None:
    stored = Path(frangible.__file__).with_name("scene.schema.json").read_text(encoding="utf-8")
    rule = "write it anew: frangible schema > python/frangible/scene.schema.json"
    assert json.loads(stored) == frangible.scene_schema(), rule


def valued(value: Any) -> Any:
    """A scene without the fields that have no value."""
    if isinstance(value, dict):
        return {key: valued(item) for key, item in value.items() if item is not None}
    return [valued(item) for item in value] if isinstance(value, list) else value


@pytest.mark.parametrize("shot", ["wall", "masonry", "nut", "pane", "bonded-pillar"])
def test_a_shot_in_toml_is_the_same_scene(shot: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scene", shot, "--toml"]) == 0
    text = capsys.readouterr().out
    assert tomllib.loads(text) == valued(json.loads(frangible.shot_scene(shot)))
    vector = [line for line in text.splitlines() if line.startswith("gravity")]
    assert len(vector) == 1 and vector[0].endswith("]"), "a vector stays in one line"


@pytest.mark.parametrize(
    "scene",
    [
        {},
        {"a b": 1, "": 2, "ü": {"x.y": {}, 'q"': [[], [[1.0, -0.0], [1e300, 5e-324]]]}},
        {"text": 'quote " slash \\ tab \t line \n del \x7f nul \x00 \U0001f600', "on": True},
        {"large": 2**63, "numbers": [math.inf, -math.inf, 1e16, 10.0], "empty": [], "none": None},
        {"list": [{"a": 1}, {"b": [{"c": [1, 2]}, {"c": {"d": "x" * 200}}]}], "last": 1},
        {"mixed": [1, {"a": None, "b": 1}, "x"], "rows": [[float(i), 1e-9] for i in range(40)]},
    ],
)
def test_anything_in_toml_is_read_back(scene: dict[str, Any]) -> None:
    assert tomllib.loads(as_toml(scene)) == valued(scene)


def test_a_list_without_a_value_is_no_toml() -> None:
    with pytest.raises(BuildError, match=r"bodies\[0\].position\[1\]: null, must have a value"):
        as_toml({"bodies": [{"position": [0, None, 1]}, 3]})


def test_a_scene_is_the_same_from_everywhere(tmp_path: Path) -> None:
    scene = a_scene()
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(scene))
    arrays = copy.deepcopy(scene)
    arrays["bodies"][1]["position"] = np.array([0, 1, 0])
    arrays["bodies"][1]["density"] = np.float32(2400)
    arrays["bodies"][1]["breaking"]["pattern"]["cells"] = np.int64(12)
    arrays["bodies"][2]["position"] = (5.0, 1, 0)
    hashes = set()
    for given in (scene, json.dumps(scene), path, str(path), arrays):
        world = World.build(given, 1)
        world.step()
        hashes.add(world.state_hash())
    assert len(hashes) == 1


def test_a_shot_that_is_printed_runs_as_the_shot_does(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["scene", "wall-ball"]) == 0
    path = tmp_path / "scene.json"
    path.write_text(capsys.readouterr().out)
    ends = []
    for name in ("wall-ball", str(path)):
        assert main(["run", name, "--json", "--quiet", "--threads", "1"]) == 0
        captured = capsys.readouterr()
        assert captured.err == ""
        ends.append(json.loads(captured.out))
    assert ends[0]["state_hash"] == ends[1]["state_hash"] and ends[0]["frames"] == ends[1]["frames"]


def test_fields_are_set_by_name_and_number(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(a_scene()))
    arguments = [
        "bodies.wall.breaking.strength=2e6",
        "bodies[2].position[1]=3",
        "bodies.stool.look=wood",
        "gravity=[0,0,0]",
    ]
    assert (
        main(["scene", str(path), *(word for text in arguments for word in ("--set", text))]) == 0
    )
    scene = json.loads(capsys.readouterr().out)
    assert scene["bodies"][1]["breaking"]["strength"] == 2e6
    assert scene["bodies"][2]["position"] == [5, 3, 0]
    assert scene["bodies"][3]["look"] == "wood"
    assert scene["gravity"] == [0, 0, 0]


@pytest.mark.parametrize(
    ("assignment", "words"),
    [
        ("bodies.wal.density=3", ["bodies.wal.density", "'wal'", "did you mean 'wall'?"]),
        ("bodies[9].density=3", ["bodies[9].density", "'9'", "below 5"]),
        ("bodies.wall.density.x=3", ["bodies.wall.density.x", "2400"]),
        ("bodies.wall.densty=3", ["bodies[1].densty", "did you mean 'density'?", '"wall"']),
        ("bodies.wall.density=heavy", ["bodies[1].density", '"heavy"', "a finite number"]),
        ("density", ["PATH=VALUE"]),
    ],
)
def test_what_cannot_be_set_is_named(
    assignment: str, words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(a_scene()))
    assert main(["run", str(path), "--set", assignment]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert [word for word in words if word not in line] == [], line


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (
            "bodies.1.density",
            math.nan,
            ["bodies[1].density: NaN, must be a finite number", 'body "wall"'],
        ),
        ("bodies.1.density", math.inf, ["bodies[1].density: Infinity, must be"]),
        ("bodies.1.density", 10**400, ["bodies[1].density", "1.8e308"]),
        ("bodies.1.density", None, ["bodies[1].density: null, must be a finite number"]),
        ("bodies.1.density", {"kind": "box"}, ["bodies[1].density: {", "must be a finite number"]),
        ("bodies.1.position", [0, 1], ["bodies[1].position: [0,1], must be a list of 3 numbers"]),
        ("bodies.1.position", [0, "1", 0], ['bodies[1].position[1]: "1", must be a finite number']),
        ("bodies.1.position", [0, math.nan, 0], ["bodies[1].position[1]: NaN"]),
        ("bodies.1.look", "glas", ["bodies[1].look", '"glas"', "did you mean 'glass'?"]),
        ("bodies.1.shape", {"kind": "bx"}, ["bodies[1].shape.kind", '"bx"', "did you mean 'box'?"]),
        ("bodies.1.shape", {}, ["bodies[1].shape.kind: missing, must be one of half-space"]),
        (
            "bodies.1.shape",
            {"kind": "box"},
            ["bodies[1].shape.size: missing, must be a list of 3 numbers"],
        ),
        ("bodies.1.shape", 3, ["bodies[1].shape: 3, must be an object whose kind is one of"]),
        (
            "bodies.1.breaking.pattern.cells",
            1.5,
            ["bodies[1].breaking.pattern.cells: 1.5, must be a whole number"],
        ),
        (
            "bodies.1.breaking.pattern.cells",
            10**9,
            ["bodies[1].breaking.pattern.cells: 1000000000, must be"],
        ),
        (
            "bodies.1.breaking.pattern.seed",
            -1,
            ["bodies[1].breaking.pattern.seed: -1, must be a whole number"],
        ),
        (
            "bodies.1.breaking.strength",
            "papier",
            ["bodies[1].breaking.strength", '"papier"', "glass"],
        ),
        (
            "bodies.1.breaking.strength",
            [1],
            ["bodies[1].breaking.strength: [1], must be a finite number, or one of glass"],
        ),
        (
            "bodies.1.breaking.strength.tensile_strength",
            "x",
            ["bodies[1].breaking.strength.tensile_strength"],
        ),
        (
            "bodies.1.breaking.strenth",
            3,
            ["bodies[1].breaking.strenth", "did you mean 'strength'?"],
        ),
        ("bodies.2.shape.points", [[0, 0, 0]] * 5, ["bodies[2].shape.points", "5 points"]),
        ("bodies.2.shape.points.1", [0, 0], ["bodies[2].shape.points[1]", "3 numbers"]),
        ("bodies.3.shape.parts.1.size", "x", ["bodies[3].shape.parts[1].size"]),
        ("bodies.4.bonds.anchors.0.low", {"x": 1}, ["bodies[4].bonds.anchors[0].low"]),
        (
            "bodies.1.shape",
            {"kind": "mesh", "path": "no.obj"},
            ["bodies[1].shape.path", "no.obj", "no such file"],
        ),
        (
            "bodies.1.breaking.pattern",
            {"kind": "file", "path": "no.json"},
            ["bodies[1].breaking.pattern.path", "no.json"],
        ),
        ("bodies", {}, ["bodies: {}, must be a list of objects"]),
        (
            "method",
            "papr",
            ['method: "papr", must be one of frame-rate, paper', "did you mean 'paper'?"],
        ),
        ("frames", 0, ["frames: 0"]),
        ("gravity", {1, 2}, ["gravity: a value of type set, must be a list of 3 numbers"]),
    ],
)
def test_path_value_and_rule(path: str, value: Any, words: list[str]) -> None:
    scene = a_scene()
    *steps, last = (int(step) if step.isdecimal() else step for step in path.split("."))
    place: Any = scene
    for step in steps:
        place = place[step]
    place[last] = value
    line = refusal(scene)
    assert "\n" not in line and [word for word in words if word not in line] == [], line
    if not isinstance(value, set):
        # The same, and Python's NaN, from JSON.
        assert refusal(json.dumps(scene)) == line


def test_a_scene_without_bodies_is_refused() -> None:
    with pytest.raises(frangible.BuildError, match=r"^bodies: \[\], must have one at least$"):
        frangible.run({"bodies": []}, frames=2)


def test_no_scene_at_all() -> None:
    for scene in (3, [], None, "null", "[]"):
        assert refusal(scene).startswith("scene: "), scene
    assert "bodies: missing" in refusal({})
    assert "line 1, column 2" in refusal("{")
    endless: list[Any] = []
    endless.append(endless)
    assert refusal({"bodies": endless}).startswith("bodies[0]: ")


BAD: list[Any] = [
    None, True, "x", -1, 0, 1e308, -1e308, 5e-324, 1e9, 1e-12, 2**63, 2**64, 10**400, math.nan,
    -math.inf, [], {}, [0, 0, 0],
    [1e308] * 3, [[[[]]]], "\u0000", "é" * 1000, {"kind": "box"}, {"kind": "mesh", "path": "/"},
    {"kind": "compound", "parts": []},
    {"kind": "triangles", "positions": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
     "triangles": [[0, 1, 9]]},
    {"kind": "voronoi", "cells": 10**9}, {"kind": "slices", "axis": [0, 0, 0]},
    {"voxels": [2**40] * 3}, {"voxels": [0, 0, 0]},
    {"sample_spacing": 1e-9}, {"kind": "radial", "spokes": 2**62, "rings": 2**62},
]  # fmt: skip


def places(value: Any, here: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    items = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, list)
        else ()
    )
    return [here, *(place for key, item in items for place in places(item, (*here, key)))]


def test_every_refusal_of_a_damaged_scene_names_a_field() -> None:
    """A few hundred scenes with one thing wrong, always the same ones."""
    draw = random.Random(41)
    all_places = [place for place in places(a_scene()) if place]
    fields = {name for name in re.findall(r"[a-z_]+", json.dumps(frangible.scene_schema()))}
    refused = 0
    for _ in range(400):
        scene = a_scene()
        *steps, last = draw.choice(all_places)
        parent: Any = scene
        for step in steps:
            parent = parent[step]
        change = draw.choice(["replace", "replace", "delete", "unknown"])
        if change == "delete":
            del parent[last]
        elif change == "unknown" and isinstance(parent, dict):
            parent["nonsense"] = 1
        else:
            parent[last] = draw.choice(BAD)
        try:
            World.build(json.dumps(scene), 1)
        except BuildError as error:
            refused += 1
            line = str(error)
            path, colon, rest = line.partition(": ")
            assert colon and len(rest) > 3 and len(line) < 600 and " column " not in line, line
            named = re.sub(r"\[\d+\]", "", path).split(".")
            assert set(named) <= fields | {"nonsense"}, line
            assert "must" in rest or "file" in rest or "folder" in rest, line
    assert refused > 150


def run_in_child(work: Any) -> int:
    """The status of a forked child that does it, or -1 if it hangs."""
    process = os.fork()
    if process == 0:
        try:
            work()
            os._exit(0)
        except BaseException:
            os._exit(1)
    for _ in range(600):
        ended, status = os.waitpid(process, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.05)
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)
    return -1


def test_a_forked_child_goes_on_as_its_parent_would(tetrahedron: str, tmp_path: Path) -> None:
    mesh = tmp_path / "tetrahedron.obj"
    mesh.write_text(tetrahedron)
    script = f"""
import os, sys, frangible
sys.path.insert(0, {str(Path(__file__).parent)!r})
from test_scenes import run_in_child
ground = dict(motion="static", shape=dict(kind="half-space"))
box = dict(shape=dict(kind="box", size=[1, 1, 1]), position=[0, 0.5, 0], angular_velocity=[0, 1, 0])
world = frangible.World.build(dict(bodies=[ground, box]), 2)
frangible.mesh_info({str(mesh)!r})
frangible.break_mesh({str(mesh)!r}, frangible.Pattern.named("voronoi"), voxels=16)
for _ in range(4):
    world.step()
path = {str(tmp_path / "hash")!r}
def child():
    for _ in range(4):
        world.step()
    world.penetrations(), world.surface(int(world.ids[-1]))
    frangible.break_mesh({str(mesh)!r}, frangible.Pattern.named("voronoi"), voxels=16)
    open(path, "w").write(world.state_hash())
status = run_in_child(child)
for _ in range(4):
    world.step()
assert status == 0, status
assert open(path).read() == world.state_hash()
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr


def test_a_world_is_used_by_one_thread_at_a_time() -> None:
    world = World.build(frangible.shot_scene("stack"), 1)
    said: list[str] = []

    def use() -> None:
        while stepping.is_alive() and not said:
            try:
                len(world.ids), world.penetrations()
            except RuntimeError as error:
                said.append(str(error))

    def step() -> None:
        for _ in range(200):
            try:
                world.step()
            except RuntimeError as error:
                said.append(str(error))
            if said:
                return

    stepping, using = threading.Thread(target=step), threading.Thread(target=use)
    stepping.start(), using.start()
    stepping.join(), using.join()
    assert said and set(said) == {
        "the world is in use by another thread: only one thread at a time may use a world"
    }
    world.step()


def test_errors_of_momentum_are_relative_to_what_is_there() -> None:
    """Three boxes that overlap push each other apart without gravity: all momenta are rounding."""

    def box(x: float, y: float, orientation: list[float]) -> dict[str, Any]:
        return {
            "shape": {"kind": "box", "size": [1, 1, 1]},
            "position": [x, y, 0],
            "orientation": orientation,
        }

    still = [0, 0, 0, 1]
    for scale in (1.0, 1e-3, 100.0):
        bodies = [box(0, 0.5, still), box(0.1, 1.4, still), box(0.2, 2.3, [0.1, 0.2, 0.3, 1])]
        for body in bodies:
            body["shape"]["size"] = [scale] * 3
            body["position"] = [scale * x for x in body["position"]]
        world = World.build({"gravity": [0, 0, 0], "bodies": bodies}, 1)
        for _ in range(30):
            momentum = world.step()["momentum"]
            assert momentum["linear_error"] < 1e-12 and momentum["angular_error"] < 1e-12
    # Real momentum is still measured: a body in flight has its own momentum for a scale.
    world = World.build({"bodies": [{**box(0, 0, still), "linear_velocity": [100, 0, 0]}]}, 1)
    assert world.step()["momentum"]["linear_error"] < 1e-15
