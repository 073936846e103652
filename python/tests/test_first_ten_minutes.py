"""A new user's ten minutes: the demo, then a mesh and a scene of one's own; a browser plays
both."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from frangible import Recording
from test_page import blob, needs_chromium, play

__all__ = ["play"]

ROOT = Path(__file__).parents[2]
COMMANDS = Path(sys.executable).parent

#: An arch, as two posts and a beam that are one surface.
ARCH = """
v -0.5 0 0\nv -0.3 0 0\nv -0.3 0.6 0\nv 0.3 0.6 0\nv 0.3 0 0\nv 0.5 0 0\nv 0.5 0.8 0\nv -0.5 0.8 0
v -0.5 0 0.2\nv -0.3 0 0.2\nv -0.3 0.6 0.2\nv 0.3 0.6 0.2
v 0.3 0 0.2\nv 0.5 0 0.2\nv 0.5 0.8 0.2\nv -0.5 0.8 0.2
f 2 1 8 3\nf 3 8 7 4\nf 4 7 6 5\nf 9 10 11 16\nf 16 11 12 15\nf 15 12 13 14
f 1 2 10 9\nf 2 3 11 10\nf 3 4 12 11\nf 4 5 13 12\nf 5 6 14 13\nf 6 7 15 14\nf 7 8 16 15\nf 8 1 9 16
"""

PIECES = 20
SCENE = f"""frames = 24
[[bodies]]
name = "ground"
motion = "static"
shape = {{ kind = "half-space" }}
[[bodies]]
name = "arch"
shape = {{ kind = "mesh", path = "arch.obj" }}
breaking = {{ strength = 50, pieces = {PIECES}, pattern = {{ kind = "voronoi" }} }}
[[bodies]]
name = "ball"
shape = {{ kind = "sphere", radius = 0.1 }}
position = [0, 0.7, 1]
linear_velocity = [0, 0, -15]
density = 7800
"""


def run_scene(folder: Path, *more: str) -> Recording:
    """Run the scene of 15 lines into arch.html and arch.npz."""
    assert len(SCENE.splitlines()) == 15
    (folder / "arch.obj").write_text(ARCH)
    (folder / "scene.toml").write_text(SCENE)
    command = [sys.executable, "-m", "frangible", "run", "scene.toml", *more]
    command += ["--out", "out/arch.html", "--out", "out/arch.npz"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return Recording.load(folder / "out" / "arch.npz")


def pieces(recording: Recording) -> int:
    return sum(body.parent is not None for body in recording.bodies)


def test_make_demo_makes_what_it_says(
    tmp_path: Path,
    play: Callable[..., dict[str, Any]],  # noqa: F811
) -> None:
    # The target itself, with the package that is tested in place of the one that it builds.
    out = tmp_path / "out"
    command = ["make", "--assume-old=.venv/.installed", f"BIN={COMMANDS}", f"OUT={out}", "demo"]
    # A make that runs this test hands on its own flags.
    own = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    done = subprocess.run(command, cwd=ROOT, env=own, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    names = ["wall.geometry.usdc", "wall.glb", "wall.html", "wall.png", "wall.usdc"]
    assert sorted(os.listdir(out)) == names
    assert done.stdout.splitlines()[-1].startswith(f"Open {out}/wall.html in a browser")
    assert f"wrote {out}/wall.html" in done.stderr
    if needs_chromium.args[0]:
        return
    shown = play(out / "wall.html", [30])
    assert shown["errors"] == [] and shown["requests"] == []
    assert shown["first"]["shot"] == "wall" and shown["first"]["bodies"] == "3 bodies"
    assert int(shown["steps"][0]["bodies"].split()[0]) > 10


def test_a_scene_of_ones_own_breaks_as_it_says(tmp_path: Path) -> None:
    recording = run_scene(tmp_path)
    assert abs(pieces(recording) - PIECES) <= 0.1 * PIECES
    header, _ = blob((tmp_path / "out" / "arch.html").read_text(encoding="utf-8"))
    assert (header["shot"], header["frames"]) == ("scene", 24)
    assert header["streams"]["birth"]["rows"] == len(recording.bodies)


def test_the_strength_decides_whether_it_breaks(tmp_path: Path) -> None:
    strong = run_scene(tmp_path, "--set", "bodies.arch.breaking.strength=5e4")
    assert pieces(strong) == 0
    more = run_scene(tmp_path, "--set", "bodies.arch.breaking.pieces=40")
    assert abs(pieces(more) - 40) <= 4


@needs_chromium
def test_a_browser_plays_a_scene_of_ones_own(
    tmp_path: Path, play: Callable[..., dict[str, Any]]
) -> None:  # noqa: F811
    recording = run_scene(tmp_path)
    shown = play(tmp_path / "out" / "arch.html", [24])
    assert shown["errors"] == [] and shown["requests"] == []
    assert shown["first"]["bodies"] == "3 bodies"
    assert shown["steps"][0]["bodies"] == f"{len(recording.alive(24))} bodies"
