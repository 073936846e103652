"""A recording with known answers, and one run of the real engine that many tests look at."""

from __future__ import annotations

import pytest
from frangible import Recording, run
from support import ScriptedWorld


@pytest.fixture(scope="session")
def scripted() -> Recording:
    return Recording.record(ScriptedWorld(), 6, shot="slab", fps=24.0)  # type: ignore[arg-type]


@pytest.fixture(scope="session")
def wall() -> Recording:
    """The wall, until a little after it broke."""
    recording = run("wall", frames=60)
    assert any(report["fractures"] for report in recording.reports), "the wall must break in the frames that tests see"
    return recording
