"""Memory of runs does not grow with their frames, and neither does that of their outputs."""

import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from frangible.io.page import PLAYER

#: A run in a process of its own, which ends with the most memory that it had in use [KiB].
RUN = """
import sys
from frangible.cli import main
assert main(sys.argv[1:]) == 0
with open("/proc/self/status") as status:
    print(status.read())
"""

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/status").exists(), reason="the system does not say how much a process used"
)


def most_memory(frames: int, outputs: list[Path]) -> float:
    """[MiB]"""
    named = [word for path in outputs for word in ("--out", str(path))]
    words = ["run", "stack", "--frames", str(frames), "--threads", "1", "--quiet", *named]
    done = subprocess.run(
        [sys.executable, "-c", RUN, *words], capture_output=True, text=True, check=True
    )
    (most,) = re.findall(r"VmHWM:\s+(\d+) kB", done.stdout)
    return int(most) / 1024


@pytest.mark.parametrize(
    ("endings", "needed"),
    [((".npz", ".glb", ".html"), "numpy"), ((".usdc", ".usda"), "pxr"), ((".abc",), "alembic3d")],
)
def test_memory_of_a_long_run_is_that_of_a_short_one(
    endings: tuple[str, ...], needed: str, tmp_path: Path
) -> None:
    """Ten times the frames take a tenth more at most."""
    if find_spec(needed) is None:
        pytest.skip(f"{needed} is not installed")
    known = [ending for ending in endings if ending != ".html" or PLAYER.exists()]
    outputs = [tmp_path / f"run{ending}" for ending in known]
    short = most_memory(300, outputs)
    sizes = [path.stat().st_size for path in outputs]
    long = most_memory(3000, outputs)
    assert long < 1.1 * short, f"{short:.0f} MiB, then {long:.0f} MiB"
    # Of a stack at rest a page holds no more than its first seconds.
    assert sum(path.stat().st_size for path in outputs) > sum(sizes)
