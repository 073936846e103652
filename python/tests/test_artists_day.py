"""A vase waits until a ball hits it: from the mesh's file to the renderer, as an artist goes."""

from __future__ import annotations

import json
import math
import os
import subprocess
from pathlib import Path
from typing import Any

import frangible
import numpy as np
import pytest
from frangible import Recording, World
from frangible.cli import main
from PIL import Image

FPS = 24
HIT = 20
FRAMES = 32
#: The wall of the vase along its height, out- and inside: radius and height [cm].
PROFILE = [
    *((0, 0), (9, 0), (14, 10), (16, 22), (13, 34), (8, 42), (9, 48)),
    *((6.5, 48), (5.5, 42), (10, 34), (13, 22), (11, 10), (7, 4), (0, 4)),
]
AROUND = 32
WISHES = (
    f"--up z --unit cm --ground --fps {FPS} --material concrete --pieces 60 --ball 6,15 "
    f"--from 0,-300,30 --hit-at-frame {HIT} --threads 1 --quiet"
).split()

BLENDER = os.environ.get("BLENDER_PYTHON")
RENDER = Path(__file__).parents[2] / "tests" / "blender" / "render.py"


def vase() -> str:
    """A vase that is open at the top, z up: as an .obj file."""
    lines: list[str] = []
    faces: list[list[int]] = []
    rings: list[list[int]] = []
    count = 0
    for radius, height in PROFILE:
        turns = range(AROUND if radius else 1)
        for turn in turns:
            angle = 2 * math.pi * turn / AROUND
            lines.append(f"v {radius * math.cos(angle)} {radius * math.sin(angle)} {height}")
        rings.append([count + 1 + turn for turn in turns])
        count += len(turns)
    for low, high in zip(rings, rings[1:]):
        for here in range(AROUND):
            there = (here + 1) % AROUND
            if len(low) == 1:
                faces.append([low[0], high[there], high[here]])
            elif len(high) == 1:
                faces.append([low[here], low[there], high[0]])
            else:
                faces.append([low[here], low[there], high[there], high[here]])
    lines += ["f " + " ".join(map(str, face)) for face in faces]
    return "\n".join(lines) + "\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """With the mesh, and the cache of the shot."""
    folder = tmp_path_factory.mktemp("day")
    (folder / "vase.obj").write_text(vase())
    out = ["--frames", str(FRAMES), "--out", str(folder / "shot.npz")]
    assert main(["run", str(folder / "vase.obj"), *WISHES, *out]) == 0
    return folder


@pytest.fixture(scope="module")
def shot(folder: Path) -> Recording:
    return Recording.load(folder / "shot.npz")


def summary(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict[str, Any]:
    assert main(["run", *map(str, arguments), *WISHES, "--json"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out.splitlines()[-1])
    return found


def test_it_stands_still_until_its_frame_and_breaks_in_it(shot: Recording) -> None:
    (whole,) = (body for body in shot.bodies if body.name == "vase")
    assert (whole.birth_frame, whole.death_frame) == (0, HIT)
    assert np.ptp(whole.positions, axis=0).tolist() == [0.0, 0.0, 0.0]
    assert np.ptp(whole.orientations, axis=0).tolist() == [0.0, 0.0, 0.0, 0.0]
    waiting = [report.get("waiting") for report in shot.reports]
    assert waiting == [1] * (HIT - 1) + [0] * (FRAMES - HIT + 1)
    assert [report["frame"] for report in shot.reports if report["fractures"]] == [HIT]


def test_it_breaks_into_the_pieces_that_were_asked_for(shot: Recording) -> None:
    pieces = [body for body in shot.alive(HIT) if body.parent is not None]
    assert len(pieces) == pytest.approx(60, rel=0.1)
    assert {body.look for body in pieces} == {"concrete"}
    (whole,) = (body for body in shot.bodies if body.name == "vase")
    assert sum(body.mass for body in pieces) == pytest.approx(whole.mass, rel=1e-9)
    # Of about the volume of the mesh, sampled.
    assert whole.mass == pytest.approx(2400 * 10.55e-3, rel=0.03)
    # All have been laid bare somewhere, and are the vase's own surface elsewhere.
    assert all(0 < np.count_nonzero(body.interior) < len(body.interior) for body in pieces)


def test_the_books_of_the_shot_balance(shot: Recording) -> None:
    for report in shot.reports:
        energy, momentum = report["energy"], report["momentum"]
        assert energy["gain"] <= 1e-9 * (energy["total"] + 1.0)
        assert max(momentum["linear_error"], momentum["angular_error"]) < 1e-9
    # The vase, at rest, enters with its weight's energy in the frame of the blow.
    started = [report["energy"].get("started", 0.0) for report in shot.reports]
    (whole,) = (body for body in shot.bodies if body.name == "vase")
    potential = whole.mass * 9.81 * whole.positions[0, 1]
    assert started[HIT - 1] == pytest.approx(potential, rel=1e-9)
    assert sum(map(abs, started)) == started[HIT - 1]


def test_nothing_jumps(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No body moves further in a frame than the larger of its speeds at its ends and gravity's gain
    in it allow; a piece is told by the place of its material in the vase."""
    assert main(["scene", str(folder / "vase.obj"), *WISHES[: WISHES.index("--threads")]]) == 0
    scene = json.loads(capsys.readouterr().out)
    # With fewer pieces, which takes less time.
    scene["bodies"][1]["breaking"]["pieces"] = 20
    world = World.build(scene, 1)
    for frame in range(1, FRAMES + 1):
        before = state(world)
        fastest = max(speed for _, _, speed in before.values())
        world.step()
        parents = dict(zip(world.ids.tolist(), world.parents, strict=True))
        for body, (rotation, origin, speed) in state(world).items():
            is_born = body not in before
            was = before[parents[body] if is_born else body]
            # What strikes it may push it before it is slower again.
            most = max(speed, fastest if is_born else was[2]) + 9.81 / FPS
            place = center(world, body)
            material = rotation.T @ (place - origin)
            moved = np.linalg.norm(place - (was[0] @ material + was[1]))
            assert moved * FPS <= most, (frame, body, moved * FPS, most)


def state(world: World) -> dict[int, tuple[Any, Any, float]]:
    """Rotation and origin of each body's material in the world, and the body's speed."""
    found = {}
    rows = zip(
        world.ids.tolist(), world.positions, world.orientations, world.velocities, strict=True
    )
    for body, place, turn, velocity in rows:
        origin, own = world.material_frame(body)
        rotation = matrix(turn)
        speed = float(np.linalg.norm(velocity))
        found[body] = (rotation @ matrix(own), rotation @ np.array(origin) + place, speed)
    return found


def center(world: World, body: int) -> Any:
    return world.positions[world.ids.tolist().index(body)]


def matrix(quaternion: Any) -> Any:
    x, y, z, w = quaternion
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * skew + 2 * skew @ skew


def test_its_strength_is_changed_by_hand(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = folder / "vase.obj"
    short = ("--frames", HIT + 1)
    stronger = summary(capsys, mesh, *short, "--set", "bodies.vase.breaking.strength=1e6")
    assert stronger["fractures"] == 0
    # It was moved all the same.
    assert stronger["energy_J"]["started"] > 0.0
    few = ("--set", "bodies.vase.breaking.pieces=8")
    weaker = summary(capsys, mesh, *short, *few, "--set", "bodies.vase.breaking.strength=5")
    assert weaker["fractures"] == 1 and weaker["first_fracture_s"] == pytest.approx(HIT / FPS)
    # It waits no longer: it stands from the first frame on.
    awake = summary(
        *(capsys, mesh, "--frames", 1, "--set", "bodies.vase.breaking.strength=1e6"),
        *("--set", "bodies.vase.starts.when=null", "--set", "bodies.vase.starts.frame=0"),
    )
    assert awake["energy_J"]["started"] > 0.0


def test_the_cache_has_a_material_inside(shot: Recording, folder: Path) -> None:
    usd = pytest.importorskip("pxr.Usd")
    from pxr import UsdGeom, UsdShade

    shot.save(folder / "shot.usdc")
    stage = usd.Stage.Open(str(folder / "shot.usdc"))
    assert stage.GetFramesPerSecond() == FPS
    pieces = {body.name for body in shot.bodies if body.parent is not None}
    bound = []
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Subset) and "inside" in prim.GetName():
            material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
            bound.append(material.GetPrim().GetName())
    assert len(bound) == len(pieces)
    assert set(bound) == {"concrete_inside"}


def pixels(path: Path) -> Any:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"))


def test_frame_30_is_drawn(shot: Recording, folder: Path) -> None:
    """By us, from the cache; and whole before the blow."""
    pictures = {}
    for frame in (HIT - 1, 30):
        path = folder / f"{frame}.png"
        assert main(["render", str(folder / "shot.npz"), "--frame", str(frame), "--out", str(path),
                     "--size", "320x180"]) == 0  # fmt: skip
        pictures[frame] = pixels(path)
    differing = np.abs(pictures[30].astype(int) - pictures[HIT - 1]).max(axis=2) > 20
    assert 0.02 < differing.mean() < 0.6


@pytest.mark.skipif(BLENDER is None, reason="needs BLENDER_PYTHON, a Python with bpy")
def test_frame_30_is_rendered_in_blender(shot: Recording, folder: Path) -> None:
    cache, picture = folder / "shot.usdc", folder / "blender.png"
    shot.save(cache)
    command = [str(BLENDER), str(RENDER), str(cache), "30", str(picture)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    lines = [line for line in done.stdout.splitlines() if line.startswith("RENDERED ")]
    assert lines, done.stderr
    seen = json.loads(lines[0].removeprefix("RENDERED "))
    assert seen["shown"] == len(shot.alive(30))
    assert {"concrete_outside", "concrete_inside"} <= set(seen["materials"])
    assert pixels(picture).std() > 5.0
