"""What a stranger's input, another process or a closed door may do: nothing is deleted that is not
ours, nothing runs for ever, and all of it is told in a sentence."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import time
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from frangible import CacheError, Recording, World, run
from frangible.cli import main
from frangible.io.page import streaming_page
from frangible.io.page_server import PageServer
from frangible.journal import read_journal
from frangible.kept_folder import KeptFolder
from frangible.scenes import read_scene
from frangible.words import for_terminal
from kill_and_resume import command
from test_bad_input import complain as complain

#: Runs the command, and answers with the sentence that it ends with.
Complain = Callable[..., str]

#: Its first frame takes seconds: so many cubes break into so many pieces.
LONG_FRAME = {
    "bodies": [
        {"motion": "static", "shape": {"kind": "half-space"}},
        *(
            {
                "shape": {"kind": "box", "size": [1.0, 1.0, 1.0]},
                "position": [3.0 * number, 0.51, 0.0],
                "linear_velocity": [0.0, -30.0, 0.0],
                "breaking": {"strength": 1.0, "pattern": {"kind": "voronoi"}, "pieces": 80},
            }
            for number in range(300)
        ),
    ]
}


def test_what_no_run_wrote_stays(tmp_path: Path, complain: Complain) -> None:
    """Also beside what one wrote."""
    out = tmp_path / "o.npz"
    folder = tmp_path / "o.npz.part"
    precious = folder / "deep" / "thesis.txt"
    precious.parent.mkdir(parents=True)
    precious.write_text("precious")
    given = ["run", "stack", "--frames", "2", "--quiet", "--out", out]
    for _ in range(2):
        assert "'deep', which no run wrote there" in complain(*given)
        assert precious.read_text() == "precious" and not out.exists()
        (folder / "frames").write_bytes(b"")
    precious.unlink()
    precious.parent.rmdir()
    (folder / "frames").write_text("of a film")
    assert "'frames', which no run wrote there" in complain(*given)
    (folder / "frames").write_bytes(b"")
    assert main([str(argument) for argument in given]) == 0
    assert os.listdir(tmp_path) == ["o.npz"]


def test_a_run_keeps_others_out_until_it_ends(tmp_path: Path, complain: Complain) -> None:
    out = tmp_path / "two.npz"
    given = ["run", "stack", "--quiet", "--out", str(out), "--frames"]
    with subprocess.Popen(command(*given, "100000")) as first:
        while not (tmp_path / "two.npz.part" / "checkpoint").exists():
            time.sleep(0.01)
        for more in ([], ["--resume"]):
            assert "another run writes it" in complain(*given, "2", *more)
        assert first.poll() is None
        # However it ends, the next one may.
        first.kill()
    assert main([*given, "2"]) == 0
    assert Recording.load(out).frames == 2
    assert os.listdir(tmp_path) == ["two.npz"]


def test_a_folder_that_went_is_not_locked(tmp_path: Path) -> None:
    first = KeptFolder(str(tmp_path / "a.part"), is_new=True)
    with pytest.raises(CacheError, match="another run writes it"):
        KeptFolder(str(tmp_path / "a.part"), is_new=True)
    first.remove()
    assert not (tmp_path / "a.part").exists()
    KeptFolder(str(tmp_path / "a.part"), is_new=True).remove()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_long_frame(number: signal.Signals, tmp_path: Path) -> None:
    """With the outputs of the frames before it."""
    scene, out = tmp_path / "long.json", tmp_path / "long.npz"
    scene.write_text(json.dumps(LONG_FRAME))
    given = command("run", str(scene), "--quiet", "--frames", "3", "--out", str(out))
    with subprocess.Popen(given, stderr=subprocess.PIPE, text=True) as process:
        kept = tmp_path / "long.npz.part" / "frames"
        while not (kept.exists() and any(r.kind == "frame" for r in read_journal(str(kept)))):
            time.sleep(0.01)
        time.sleep(0.5)
        process.send_signal(number)
        begin = time.monotonic()
        _, said = process.communicate(timeout=30)
    assert time.monotonic() - begin < 3.0
    assert process.returncode == 128 + number
    assert said == "frangible: stopped after 0 of 3 frames; outputs are of those\n"
    assert Recording.load(out).frames == 0


def test_a_frame_that_is_interrupted_is_undone() -> None:
    """And done again it ends in the same state as without."""
    few = {"bodies": LONG_FRAME["bodies"][:6]}
    world, undisturbed = World.build(few, 1), World.build(few, 1)
    before = world.state_hash()

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    handler = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.1)
    try:
        with pytest.raises(KeyboardInterrupt):
            world.step()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, handler)
    # What was called off ends by itself.
    time.sleep(0.5)
    spent = time.process_time()
    time.sleep(0.5)
    assert time.process_time() - spent < 0.2
    assert world.state_hash() == before
    world.stop_step()
    with pytest.raises(KeyboardInterrupt, match="stopped"):
        world.step()
    assert world.state_hash() == before
    world.step()
    undisturbed.step()
    assert world.state_hash() == undisturbed.state_hash()


@pytest.mark.parametrize("ending", ["json", "toml"])
def test_numbers_without_end_are_refused(ending: str, tmp_path: Path, complain: Complain) -> None:
    digits = "1" * 5000
    scene = tmp_path / f"scene.{ending}"
    scene.write_text(
        f'{{"gravity": [0, {digits}, 0]}}' if ending == "json" else f"gravity = [0, {digits}, 0]"
    )
    assert "more than 4300 digits" in complain("run", scene)
    assert "4300 digits" in complain("run", "stack", "--set", f"gravity={digits}")
    assert "from 1 to" in complain("run", "stack", "--frames", digits)
    assert "must be WIDTHxHEIGHT" in complain("render", "x.npz", "--size", f"{digits}x16")


def test_keys_without_end_are_refused(tmp_path: Path, complain: Complain) -> None:
    key = "a." * 20_000 + "a"
    scene = tmp_path / "scene.toml"
    for text in (f"{key} = 1", f"[{key}]", f'b = {{"a" . {key} = 1}}'):
        scene.write_text(f"# one\n{text}\n")
        begin = time.process_time()
        said = complain("run", scene)
        assert "line 2: the key" in said and "at most 64 parts" in said and len(said) < 400
        assert time.process_time() - begin < 2.0
    assert "at most 64 parts" in complain("run", "stack", "--set", f"{key}=1")
    # Dots elsewhere are none of keys.
    scene.write_text(f'name = "{"." * 500} 1.5.2"\nbodies = []\n# {"a " * 10_000}\n')
    assert read_scene(scene)["bodies"] == []


def test_an_output_that_takes_nothing_is_told() -> None:
    for arguments in (["run", "stack", "--frames", "1", "--quiet", "--json"], ["shots"]):
        with open("/dev/full", "w") as full:
            done = subprocess.run(
                command(*arguments), stdout=full, stderr=subprocess.PIPE, text=True
            )
        assert done.returncode == 1
        assert done.stderr == "frangible: output: No space left on device\n"


def test_names_do_not_reach_the_terminal_as_they_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = tmp_path / "scene.json"
    scene.write_text(json.dumps({**LONG_FRAME, "name": "\x1b[31mred\x9b", "bodies": []}))
    assert main(["run", str(scene), "--set", "bodies=" + json.dumps(LONG_FRAME["bodies"][:1]),
                 "--frames", "1", "--quiet"]) == 0  # fmt: skip
    assert main(["info", str(tmp_path / "\x1b[2J.obj")]) == 2
    out, err = capsys.readouterr()
    assert "\\u{1b}[31mred\\u{9b}" in out and "\\u{1b}[2J.obj" in err
    assert not {"\x1b", "\x9b"} & {*out, *err}
    assert for_terminal("a\tb\n" + "x" * 5000).endswith(" ...")
    assert "\u202e" not in for_terminal("\u202e")


def bomb(fan: int, depth: int, arc: str) -> str:
    """A stage whose references multiply."""
    layers = ['#usda 1.0\n(\n    defaultPrim = "A0"\n)\n']
    for level in range(depth):
        inner = "".join(
            f'def "c{i}" (\n{arc} = </A{level + 1}>\n)\n{{\n}}\n' for i in range(fan)
        )
        layers.append(f'{"class" if level else "def Xform"} "A{level}"\n{{\n{inner}}}\n')
    return "".join([*layers, f'class "A{depth}"\n{{\ndef Cube "cube"\n{{\n}}\n}}\n'])


@pytest.mark.parametrize(
    "arc",
    ["prepend references", "prepend payload", "prepend inherits", "add specializes",
     "instanceable = true\nreferences"],
)  # fmt: skip
def test_references_that_multiply_are_refused_before_they_do(
    arc: str, tmp_path: Path, complain: Complain
) -> None:
    pytest.importorskip("pxr")
    stage = tmp_path / "bomb.usda"
    stage.write_text(bomb(10, 8, arc))
    for arguments in (["info", stage], ["run", stage, "--frames", "1"]):
        assert "has more than 500000 prims" in complain(*arguments)


def test_references_that_do_not_multiply_are_read(tmp_path: Path) -> None:
    """In files of their own, in sublayers and variants, and to themselves."""
    pytest.importorskip("pxr")
    from frangible.io.usd_bounds import _Counter
    from pxr import Sdf, Usd

    (tmp_path / "asset.usda").write_text(bomb(3, 3, "references"))
    (tmp_path / "below.usda").write_text('#usda 1.0\ndef "more"\n{\ndef Cube "one"\n{\n}\n}\n')
    (tmp_path / "stage.usda").write_text(
        "#usda 1.0\n(\nsubLayers = [@below.usda@, @gone.usda@]\n)\n"
        'def "a" (\nreferences = @asset.usda@\n)\n{\n}\n'
        'def "b" (\nreferences = [@gone.usda@, </b>]\n'
        ')\n{\n}\ndef "c" (\nvariants = {\nstring v = "x"\n}\nprepend variantSets = "v"\n)\n{\n'
        'variantSet "v" = {\n"x" {\ndef "d" (\nreferences = @asset.usda@\n)\n{\n}\n}\n}\n}\n'
    )
    path = str(tmp_path / "stage.usda")
    counted = _Counter().count(Sdf.Layer.FindOrOpen(path), Sdf.Path.absoluteRootPath)
    stage = Usd.Stage.Open(path)
    there = sum(1 for _ in stage.TraverseAll())
    # Each reference counts its target besides what it is laid on.
    assert there < counted < 3 * there


def test_an_archive_is_looked_at_before_it_is_unpacked(tmp_path: Path, complain: Complain) -> None:
    zeros = np.zeros(2**25)
    path = tmp_path / "large.npz"
    np.savez_compressed(path, positions=zeros)
    begin = time.process_time()
    assert "has no key 'format', so it is not a Frangible cache" in complain("info", path)
    assert time.process_time() - begin < 0.5

    # With all its keys: the shapes are looked at, too.
    good = tmp_path / "good.npz"
    run("stack", frames=1).save(good)
    with zipfile.ZipFile(good) as archive, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as bad:
        for name in archive.namelist():
            with bad.open(name, "w") as out:
                if name == "positions.npy":
                    np.lib.format.write_array(out, zeros)
                else:
                    out.write(archive.read(name))
    begin = time.process_time()
    assert "positions: (33554432,) of float64" in complain("info", path)
    assert time.process_time() - begin < 0.5


def test_a_recording_may_begin_after_a_burst(tmp_path: Path) -> None:
    scene = {
        "bodies": [
            {"shape": {"kind": "box", "size": [1, 1, 1]}, "material": "concrete",
             "position": [0, 3, 0]}
        ]
    }  # fmt: skip
    world = World.build(scene, 1)
    pieces = world.burst(int(world.ids[0]), [0, 3.5, 0], 1.0)
    assert len(pieces) > 1
    path = tmp_path / "burst.npz"
    Recording.record(world, 3).save(path)
    assert {body.id for body in Recording.load(path).alive(0)} == {*pieces}


@pytest.mark.parametrize("look", ["colour", "material"])
@pytest.mark.parametrize("ending", ["usda", "glb", "npz"])
def test_a_plane_of_a_stage_keeps_its_look(look: str, ending: str, tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    said = (
        'uniform color3f[] primvars:displayColor = [(0.8, 0.1, 0.1)] (interpolation = "constant")'
        if look == "colour"
        else "rel material:binding = </Mat>"
    )
    stage = tmp_path / "plane.usda"
    stage.write_text(
        '#usda 1.0\n(\nupAxis = "Z"\nmetersPerUnit = 1\n)\ndef PhysicsScene "Scene" {\n}\n'
        'def Plane "floor" (prepend apiSchemas = ["PhysicsCollisionAPI", "MaterialBindingAPI"])\n'
        f'{{\nuniform token axis = "Z"\n{said}\n}}\n'
        'def Cube "box" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"])\n{\n'
        "double3 xformOp:translate = (0, 0, 3)\n"
        'uniform token[] xformOpOrder = ["xformOp:translate"]\n}\n'
        'def Material "Mat"\n{\ntoken outputs:surface.connect = </Mat/S.outputs:surface>\n'
        'def Shader "S"\n{\nuniform token info:id = "UsdPreviewSurface"\n'
        "color3f inputs:diffuseColor = (0.8, 0.1, 0.1)\ntoken outputs:surface\n}\n}\n"
    )
    out = tmp_path / f"out.{ending}"
    assert main(["run", str(stage), "--frames", "1", "--quiet", "--out", str(out)]) == 0
    if ending == "npz":
        out = tmp_path / "again.usda"
        Recording.load(tmp_path / "out.npz").save(out)
    geometry = out.with_name(f"{out.stem}.geometry.usda")
    text = (geometry if geometry.exists() else out).read_bytes()
    assert re.search(rb"0\.80*\d*, ?0\.(1|09999)", text)


def test_requests_that_are_none_and_pages_that_close_say_nothing(
    capfd: pytest.CaptureFixture[str],
) -> None:
    with PageServer(streaming_page("x" * 10_000_000)) as server:
        address = server.host.split(":")
        for path in ("/", "nothing", f"/{server.token}/"):
            request = f"GET {path} HTTP/1.1\r\nHost: {server.host}\r\n\r\n"
            with socket.create_connection((address[0], int(address[1]))) as client:
                client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
                client.sendall(request.encode())
                with suppress(ConnectionError):
                    client.recv(100)
        time.sleep(0.3)
    assert capfd.readouterr().err == ""


def test_a_long_line_of_a_stage_is_cut(tmp_path: Path, complain: Complain) -> None:
    pytest.importorskip("pxr")
    stage = tmp_path / "long.usda"
    stage.write_text("#usda 1.0\ndef " + "x" * 100_000 + "\n")
    with suppress(ValueError):
        assert len(complain("info", stage)) < 2000


def test_the_lock_has_what_the_package_asks_for() -> None:
    import tomllib

    from packaging.requirements import Requirement

    top = Path(__file__).parents[2]
    project = tomllib.loads((top / "pyproject.toml").read_text())["project"]
    locked = {
        line.split("==")[0]: line.split("==")[1].split()[0]
        for line in (top / "python" / "requirements.lock").read_text().splitlines()
        if "==" in line and not line.startswith((" ", "#"))
    }
    extras = ("exact", "gltf", "usd", "film", "plot", "completion", "alembic", "notebook", "dev")
    asked = [*project["dependencies"]]
    asked += [line for extra in extras for line in project["optional-dependencies"][extra]]
    for line in asked:
        wanted = Requirement(line)
        assert wanted.specifier.contains(locked[wanted.name.lower()]), line
    assert f"LOCKED := {' '.join(extras)}\n" in (top / "Makefile").read_text()

