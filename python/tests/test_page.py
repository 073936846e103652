"""Pages that play a recording: what they hold, and that a browser plays them."""

import base64
import json
import os
import re
import shutil
import subprocess
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frangible import OutputError, Recording
from frangible.camera import frame_recording
from frangible.page import ASPECT, DATA, PLAYER, TITLE
from frangible.page_data import encode
from support import TOOLS

CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium")
needs_chromium = pytest.mark.skipif(
    CHROMIUM is None, reason="Chromium is not installed: apt-get install chromium, or name one in CHROMIUM"
)

Play = Callable[..., dict[str, Any]]


@pytest.fixture
def play() -> Play:
    """The state of a page in headless Chromium: it plays by itself, then stops at the frames asked for."""

    def run(page: Path, frames: list[int], *pictures: str) -> dict[str, Any]:
        command = ["node", str(TOOLS / "play_page.js"), str(page), "--frames", ",".join(map(str, frames))]
        for picture in pictures:
            command += ["--picture", picture]
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=240, env={**os.environ, "CHROMIUM": CHROMIUM or ""}
        )
        assert done.returncode == 0, done.stderr
        shown: dict[str, Any] = json.loads(done.stdout)
        return shown

    return run


def blob(page: str) -> tuple[dict[str, Any], bytes]:
    """Header and streams of a page."""
    (data,) = re.findall(r'id="recording">([^<]*)</script>', page)
    inflated = zlib.decompress(base64.b64decode(data))
    end = 4 + int.from_bytes(inflated[:4], "little")
    return json.loads(inflated[4:end]), inflated[end:]


def columns(recording: Recording, name: str) -> np.ndarray[Any, Any]:
    """A stream, (rows, columns), read as the format says."""
    inflated = zlib.decompress(encode(recording, frame_recording(recording, ASPECT)))
    end = 4 + int.from_bytes(inflated[:4], "little")
    info = json.loads(inflated[4:end])["streams"][name]
    count = info["rows"] * info["columns"]
    folded = np.zeros(count, np.int64)
    for plane in range(info["bytes"]):
        begin = end + info["offset"] + plane * count
        folded |= np.frombuffer(inflated[begin : begin + count], np.uint8).astype(np.int64) << (8 * plane)
    values = np.where(folded & 1, -(folded + 1) // 2, folded // 2).reshape(info["columns"], info["rows"])
    for _ in range(info["order"]):
        values = np.cumsum(values, axis=1)
    return ((values + 2**31) % 2**32 - 2**31).T


def test_a_page_is_whole_and_refers_to_nothing_outside_itself(scripted: Recording, tmp_path: Path) -> None:
    shot = "</script><b>a & b"
    replace(scripted, shot=shot).save(tmp_path / "slab.html")
    page = (tmp_path / "slab.html").read_text(encoding="utf-8")
    assert "<title>&lt;/script&gt;&lt;b&gt;a &amp; b</title>" in page
    assert "default-src 'none'" in page
    assert not re.findall(r'(?:src|href)="(?!data:,")[^"]*"', page)
    assert DATA not in page and TITLE not in page
    header, _ = blob(page)
    assert (header["shot"], header["frames"], header["fps"]) == (shot, 6, 24.0)


def test_positions_and_lives_are_those_of_the_recording(wall: Recording) -> None:
    camera = frame_recording(wall, ASPECT)
    step = float((camera.target - camera.eye) @ camera.axes[2]) / 2**17
    positions = columns(wall, "positions") * step
    counts = columns(wall, "poses")[:, 0]
    first = np.concatenate([[0], np.cumsum(counts)])
    for row, body in enumerate(wall.bodies):
        # After its last pose a body rests.
        rows = first[row] + np.minimum(np.arange(len(body.positions)), counts[row] - 1)
        assert np.abs(positions[rows] - body.positions).max() <= 0.51 * step
    assert columns(wall, "birth")[:, 0].tolist() == [body.birth_frame for body in wall.bodies]
    ends = [61 if body.death_frame is None else body.death_frame for body in wall.bodies]
    assert columns(wall, "end")[:, 0].tolist() == ends


def test_pieces_are_pulled_from_their_parents_centre_and_not_into_the_floor(scripted: Recording) -> None:
    camera = frame_recording(scripted, ASPECT)
    step = float((camera.target - camera.eye) @ camera.axes[2]) / 2**17
    pulls = {body.id: pull for body, pull in zip(scripted.bodies, columns(scripted, "pull") * step, strict=True)}
    # 2 weighs 1 kg at x = -0.5; 4 and 5 weigh 0.5 kg at 0.25 and 0.75: their middle is 0. Of these
    # 5 is the lowest, at y = 1.
    expected = {0: [0, 0, 0], 1: [0, 0, 0], 2: [-0.5, 1.5, 0], 4: [0.25, 1.5, 0], 5: [0.75, 0, 0]}
    for body, pull in expected.items():
        assert np.allclose(pulls[body], pull, atol=step), body


def test_a_recording_with_nothing_in_it_is_a_page(scripted: Recording, tmp_path: Path) -> None:
    replace(scripted, bodies=[]).save(tmp_path / "nothing.html")
    assert blob((tmp_path / "nothing.html").read_text(encoding="utf-8"))[0]["materials"] == []


def test_a_missing_player_is_a_sentence(
    scripted: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("frangible.page.PLAYER", PLAYER.with_name("nothing.html"))
    with pytest.raises(OutputError, match=r"npm ci && npm run build"):
        scripted.save(tmp_path / "slab.html")
    assert os.listdir(tmp_path) == []


@needs_chromium
def test_a_browser_plays_the_wall_from_a_file(wall: Recording, play: Play, tmp_path: Path) -> None:
    wall.save(tmp_path / "wall.html")
    broken = next(report["frame"] for report in wall.reports if report["fractures"])
    shown = play(tmp_path / "wall.html", [broken - 1, broken, 60])
    assert shown["errors"] == []
    assert shown["requests"] == []
    # It goes on by itself, and stops at frames that say how many bodies there are.
    early, later = (int(caption["frame"].split()[1]) for caption in shown["played"])
    assert early <= later and later >= 2
    assert shown["first"] == {"shot": "wall", "frame": "frame 0 of 60", "time": "0.00 s", "bodies": "3 bodies"}
    for frame, caption in zip([broken - 1, broken, 60], shown["steps"], strict=True):
        assert caption["frame"] == f"frame {frame} of 60"
        assert caption["bodies"] == f"{len(wall.alive(frame))} bodies"


@needs_chromium
def test_a_page_that_cannot_be_played_says_why(scripted: Recording, play: Play, tmp_path: Path) -> None:
    scripted.save(tmp_path / "slab.html")
    page = (tmp_path / "slab.html").read_text(encoding="utf-8")
    data = re.findall(r'id="recording">([^<]*)</script>', page)[0]
    (tmp_path / "torn.html").write_text(page.replace(data, data[: len(data) // 2]), encoding="utf-8")
    with pytest.raises(AssertionError, match="The recording cannot be played"):
        play(tmp_path / "torn.html", [1])
