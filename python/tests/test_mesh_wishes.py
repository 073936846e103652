"""One mesh file and what an artist wants of it."""

import json
from pathlib import Path
from typing import Any

import frangible
import numpy as np
import pytest
from frangible import BuildError, Recording
from frangible.cli import main
from frangible.mesh_scene import Wishes, mesh_scene

#: A block of 1 x 1 x 2 on its end, the way of z up; in centimetres.
BLOCK = """
v -50 -50 0\nv 50 -50 0\nv 50 50 0\nv -50 50 0
v -50 -50 200\nv 50 -50 200\nv 50 50 200\nv -50 50 200
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8
"""


@pytest.fixture
def block(tmp_path: Path) -> Path:
    path = tmp_path / "block.obj"
    path.write_text(BLOCK)
    return path


def printed(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict[str, Any]:
    assert main(["scene", *map(str, arguments)]) == 0
    scene: dict[str, Any] = json.loads(capsys.readouterr().out)
    return scene


def test_a_reach_is_in_the_unit_of_the_file(block: Path) -> None:
    wishes = Wishes(unit="cm", up="z", ground=True, reach=30.0)
    assert mesh_scene(block, wishes).to_dict()["bodies"][1]["breaking"] == {"reach": 0.3}


def test_a_ball_arrives_in_its_frame_and_the_mesh_breaks_into_pieces(
    block: Path, tmp_path: Path
) -> None:
    cache = tmp_path / "block.npz"
    command = f"run {block} --up z --unit cm --ground --ball 20,15 --from 0,-300,100 --fps 24"
    wishes = "--hit-at-frame 20 --pieces 60 --material concrete --frames 24 --quiet --threads 1"
    assert main([*command.split(), *wishes.split(), "--out", str(cache)]) == 0
    recording = Recording.load(cache)
    broken = [report["frame"] for report in recording.reports if report["fractures"]]
    assert broken[0] == 20
    pieces = sum(body.parent is not None for body in recording.alive(20))
    assert 54 <= pieces <= 66
    block_body = next(body for body in recording.bodies if body.name == "block")
    assert block_body.mass == pytest.approx(2 * 2400, rel=1e-3)
    low, high = (f(block_body.vertices_world(0), axis=0) for f in (np.min, np.max))
    assert low == pytest.approx([-0.5, 0, -0.5], abs=0.01)
    assert high == pytest.approx([0.5, 2, 0.5], abs=0.01)
    assert block_body.look == "concrete"


@pytest.mark.parametrize("ground", [True, False])
@pytest.mark.parametrize("frame", [1, 7, 20])
def test_the_ball_touches_in_the_step_to_the_frame(block: Path, ground: bool, frame: int) -> None:
    """By the parabola of the ball and the fall of the mesh, told apart from the engine."""
    wishes = Wishes(
        ball=(10.0, 30.0),
        origin=(0.0, -500.0, 120.0),
        hit_at_frame=frame,
        ground=ground,
        up="z",
        unit="cm",
    )
    scene = mesh_scene(block, wishes).to_dict()
    ball = next(body for body in scene["bodies"] if body["name"] == "ball")
    gravity = np.array([0.0, -9.81, 0.0])

    def gap(time: float) -> float:
        """Between the ball and the face of the block at z = 0.5."""
        start, velocity = np.array(ball["position"]), np.array(ball["linear_velocity"])
        place = start + velocity * time + 0.5 * gravity * time**2
        assert abs(place[0]) < 1e-9 and 0.9 < place[1] < 1.25
        return float(place[2] - 0.5 - 0.1)

    assert gap((frame - 1) / 30) > 0.0 > gap(frame / 30)
    assert scene["frames"] == frame + 60


def test_wishes_become_a_scene(block: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = printed(capsys, block, "--ground", "--material", "glass", "--pattern", "natural",
                    "--strength", "500", "--seed", "3")  # fmt: skip
    ground, body = scene["bodies"]
    assert ground["shape"] == {"kind": "half-space"} and ground["position"] == [0, -50, 0]
    assert body["name"] == "block" and body["material"] == "glass"
    assert body["breaking"] == {"strength": 500, "pattern": {"kind": "natural", "seed": 3}}
    # A material of the table, and nothing said.
    scene = printed(capsys, block, "--ball", "5,3", "--strength", "brick", "--unit", "mm")
    body, ball = scene["bodies"]
    assert body["breaking"] == {"strength": "brick"} and body["shape"]["scale"] == 1e-3
    assert ball["shape"]["radius"] == 0.005 and "frames" not in scene
    # It falls on its way, and touches the front from above.
    assert 0.2 - 0.05 < ball["position"][2] - 0.5 * 3 < 0.2 + 0.005
    assert body["starts"] == {"when": "struck"}
    assert ball["linear_velocity"] == pytest.approx([0, 0.5 * 0.5 * 9.81, -3])


def test_a_usd_mesh_keeps_its_own_unit_and_axes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "block.usda"
    path.write_text(
        '#usda 1.0\n(\n metersPerUnit = 0.01\n upAxis = "Z"\n)\n'
        'def Cube "block"\n{\n double size = 100\n double3 xformOp:translate = (0, 0, 50)\n'
        ' uniform token[] xformOpOrder = ["xformOp:translate"]\n}\n'
    )
    scene = printed(capsys, path, "--ball", "10,5", "--from", "0,-300,50", "--ground")
    ground, body, ball = scene["bodies"]
    assert ground["position"][1] == pytest.approx(0) and "orientation" not in body
    assert ball["shape"]["radius"] == pytest.approx(0.1)
    assert ball["position"] == pytest.approx([0, 0.5, 3.0])
    with pytest.raises(BuildError, match="is a stage without physics, so one mesh"):
        frangible.run(path, frames=1)
    recording = frangible.run(path, frames=1, threads=1, wishes={"ground": True})
    low = next(one for one in recording.bodies if one.name == "block").vertices_world(0).min(axis=0)
    assert low == pytest.approx([-0.5, 0, -0.5], abs=0.01)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], ["is a mesh that would fall for ever", "--ball", "--ground"]),
        (["--hit-at-frame", "3", "--ground"], ["--hit-at-frame: 3, must come with a ball"]),
        (["--from", "1,2,3", "--ground"], ["--from: (1.0, 2.0, 3.0), must come with a ball"]),
        (["--ball", "1"], ["--ball", "'1', must be R,V"]),
        (["--ball", "1,-2"], ["--ball", "'-2.0', must be a number > 0"]),
        (["--from", "1,2"], ["--from", "must be X,Y,Z"]),
        (["--ground", "--unit", "inch"], ["unit: 'inch'", "must be one of mm, cm, m, km, in, ft"]),
        (["--ground", "--up", "x"], ["--up", "'x'"]),
        (["--material", "marble"], ["--material: 'marble', must be one of", "a scene file has"]),
        (["--ground", "--look", "glas"], ["bodies[1].look", "did you mean 'glass'?"]),
        (["--ground", "--material", "concret"], ["concret", "did you mean 'concrete'?"]),
        (["--ground", "--pattern", "voronio"], ["voronio", "did you mean 'voronoi'?", "or a file"]),
        (["--ground", "--material", "steel", "--pieces", "9"], ["steel", "does not break"]),
        (["--ground", "--strength", "papier"], ["bodies[1].breaking.strength", '"papier"']),
        (["--ball", "5,1", "--from", "0,0,100"], ["from", "must not be the middle of the mesh"]),
        (["--ball", "5,1", "--from", "0,0,99"], ["from", "must be a place outside the mesh"]),
        (
            "--ground --unit cm --ball 5,9 --from 0,-40,900 --hit-at-frame 99".split(),
            ["from: the ball would start", "deep in the ground"],
        ),
        (["--ground", "--mesh", "a.obj"], ["mesh: a.obj, must be left out for a mesh file"]),
    ],
)
def test_wishes_that_cannot_be_are_named(
    arguments: list[str], words: list[str], block: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        status = main(["run", str(block), "--quiet", "--frames", "1", *arguments])
    except SystemExit as ended:
        status = int(ended.code or 0)
    (line,) = capsys.readouterr().err.splitlines()
    assert status == 2 and [word for word in words if word not in line] == [], line


def test_a_ball_hits_under_another_gravity(
    block: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It rises by half of what it falls on its way; on the moon that is less."""
    for gravity in (1.62, 0.0):
        words = ["--ball", "0.05,3", "--gravity", str(gravity), "--look", "brick"]
        scene = printed(capsys, block, *words)
        body, ball = scene["bodies"]
        assert scene["gravity"] == [0, -gravity, 0] and body["look"] == "brick"
        assert ball["linear_velocity"][1] == pytest.approx(0.5 * 0.5 * gravity)


def test_wishes_of_what_is_no_mesh_file_are_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["run", "wall", "--material", "glass"]) == 2
    assert "--material: glass, must come with a mesh file; see --set" in capsys.readouterr().err
    assert main(["run", "walll"]) == 2
    said = "unknown shot 'walll' (did you mean 'wall'?), must be one that `frangible shots` lists"
    assert said in capsys.readouterr().err
    with pytest.raises(BuildError, match="no such file"):
        frangible.run("no.obj", wishes={"ground": True})
