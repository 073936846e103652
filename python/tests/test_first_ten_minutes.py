"""A new user's ten minutes: a mesh and a scene of one's own, run from the command line, played in a browser."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from test_page import blob, needs_chromium, play

__all__ = ["play"]

#: An arch, as two posts and a beam that are one surface.
ARCH = """
v -0.5 0 0\nv -0.3 0 0\nv -0.3 0.6 0\nv 0.3 0.6 0\nv 0.3 0 0\nv 0.5 0 0\nv 0.5 0.8 0\nv -0.5 0.8 0
v -0.5 0 0.2\nv -0.3 0 0.2\nv -0.3 0.6 0.2\nv 0.3 0.6 0.2\nv 0.3 0 0.2\nv 0.5 0 0.2\nv 0.5 0.8 0.2\nv -0.5 0.8 0.2
f 2 1 8 3\nf 3 8 7 4\nf 4 7 6 5\nf 9 10 11 16\nf 16 11 12 15\nf 15 12 13 14
f 1 2 10 9\nf 2 3 11 10\nf 3 4 12 11\nf 4 5 13 12\nf 5 6 14 13\nf 6 7 15 14\nf 7 8 16 15\nf 8 1 9 16
"""

SCENE = """
frames = 24
[[bodies]]
name = "ground"
motion = "static"
shape = { kind = "half-space" }
[[bodies]]
name = "arch"
shape = { kind = "mesh", path = "arch.obj", resolution = { voxels = [24, 20, 8] } }
breaking = { strength = 50, pattern = { kind = "voronoi", cells = 30 } }
[[bodies]]
name = "ball"
shape = { kind = "sphere", radius = 0.1 }
position = [0, 0.7, 1]
linear_velocity = [0, 0, -15]
density = 7800
"""


def run_scene(folder: Path) -> Path:
    (folder / "arch.obj").write_text(ARCH)
    (folder / "scene.toml").write_text(SCENE)
    command = [sys.executable, "-m", "frangible", "run", "scene.toml", "--out", "arch.html"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return folder / "arch.html"


def test_a_scene_of_ones_own_becomes_a_page(tmp_path: Path) -> None:
    header, _ = blob(run_scene(tmp_path).read_text(encoding="utf-8"))
    assert header["frames"] == 24
    assert header["streams"]["birth"]["rows"] > 5, "the arch must break"


@needs_chromium
def test_a_browser_plays_a_scene_of_ones_own(tmp_path: Path, play: Callable[..., dict[str, Any]]) -> None:  # noqa: F811
    shown = play(run_scene(tmp_path), [24])
    assert shown["errors"] == [] and shown["requests"] == []
    assert shown["first"]["bodies"] == "3 bodies"
    assert int(shown["steps"][0]["bodies"].split()[0]) > 5
