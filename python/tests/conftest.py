"""A recording with known answers, and one run of the real engine that many tests look at."""

from __future__ import annotations

import signal

import pytest
from frangible import Recording, run
from support import ScriptedWorld

# A shell's background jobs ignore interrupts, and so would the commands that tests start
# and interrupt: a handler of ours is not handed on, and they get the system's.
signal.signal(signal.SIGINT, signal.default_int_handler)
# What runs under `nohup` ignores the end of its terminal: the tests still do, what they start does
# not.
if signal.getsignal(signal.SIGHUP) == signal.SIG_IGN:
    signal.signal(signal.SIGHUP, lambda number, frame: None)


@pytest.fixture(scope="session")
def scripted() -> Recording:
    return Recording.record(ScriptedWorld(), 6, shot="slab", fps=24.0)  # type: ignore[arg-type]


@pytest.fixture(scope="session")
def wall() -> Recording:
    """The wall, until a little after it broke."""
    recording = run("wall", frames=60)
    assert any(report["fractures"] for report in recording.reports), (
        "the wall must break in the frames that tests see"
    )
    return recording


@pytest.fixture
def tetrahedron() -> str:
    """The smallest solid, as an OBJ file."""
    return "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
