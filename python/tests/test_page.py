"""Pages that play a recording: what they hold, and that a browser plays them."""

import base64
import io
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
from frangible.io.page import ASPECT, DATA, PLAYER, TITLE
from frangible.io.page_data import encode
from frangible.materials import Image, Material
from frangible.recording import Body
from frangible.render.camera import frame_recording
from frangible.render.picture import picture
from frangible.skin import Skin
from PIL import Image as Pillow
from support import TOOLS

CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium")
needs_chromium = pytest.mark.skipif(
    CHROMIUM is None,
    reason="Chromium is not installed: apt-get install chromium, or name one in CHROMIUM",
)

Play = Callable[..., dict[str, Any]]


@pytest.fixture
def play() -> Play:
    """The state of a page in headless Chromium: it plays by itself, then stops at the frames asked
    for."""

    def run(page: Path, frames: list[int], *pictures: str, size: str = "480x270") -> dict[str, Any]:
        command = ["node", str(TOOLS / "play_page.js"), str(page), "--size", size]
        if frames:
            command += ["--frames", ",".join(map(str, frames))]
        for picture in pictures:
            command += ["--picture", picture]
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            timeout=240,
            env={**os.environ, "CHROMIUM": CHROMIUM or ""},
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


def inflated_of(recording: Recording) -> bytes:
    """The blob of a page, unpacked."""
    pieces: list[bytes] = []
    encode(recording, frame_recording(recording, ASPECT), pieces.append)
    return zlib.decompress(b"".join(pieces))


def columns(recording: Recording, name: str) -> np.ndarray[Any, Any]:
    """A stream, (rows, columns), read as the format says."""
    inflated = inflated_of(recording)
    end = 4 + int.from_bytes(inflated[:4], "little")
    return stream(inflated[end:], json.loads(inflated[4:end])["streams"][name])


def stream(data: bytes, info: dict[str, int]) -> np.ndarray[Any, Any]:
    """The same of one that its header describes."""
    count = info["rows"] * info["columns"]
    folded = np.zeros(count, np.int64)
    for plane in range(info["bytes"]):
        begin = info["offset"] + plane * count
        folded |= np.frombuffer(data[begin : begin + count], np.uint8).astype(np.int64) << (
            8 * plane
        )
    values = np.where(folded & 1, -(folded + 1) // 2, folded // 2).reshape(
        info["columns"], info["rows"]
    )
    for _ in range(info["order"]):
        values = np.cumsum(values, axis=1)
    return ((values + 2**31) % 2**32 - 2**31).T


def test_a_page_is_whole_and_refers_to_nothing_outside_itself(
    scripted: Recording, tmp_path: Path
) -> None:
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
        lead = int(body.before is not None)
        rows = first[row] + np.minimum(lead + np.arange(len(body.positions)), counts[row] - 1)
        assert np.abs(positions[rows] - body.positions).max() <= 0.51 * step
    assert columns(wall, "birth")[:, 0].tolist() == [body.birth_frame for body in wall.bodies]
    ends = [61 if body.death_frame is None else body.death_frame for body in wall.bodies]
    assert columns(wall, "end")[:, 0].tolist() == ends


def test_pieces_are_pulled_from_their_parents_centre_and_not_into_the_floor(
    scripted: Recording,
) -> None:
    camera = frame_recording(scripted, ASPECT)
    step = float((camera.target - camera.eye) @ camera.axes[2]) / 2**17
    pulls = {
        body.id: pull
        for body, pull in zip(scripted.bodies, columns(scripted, "pull") * step, strict=True)
    }
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
    monkeypatch.setattr("frangible.io.page.PLAYER", PLAYER.with_name("nothing.html"))
    with pytest.raises(OutputError, match=r"npm ci && npm run build"):
        scripted.save(tmp_path / "slab.html")
    assert os.listdir(tmp_path) == []


def test_fragments_begin_where_they_were_in_their_parent(scripted: Recording) -> None:
    named = {body.id: row for row, body in enumerate(scripted.bodies)}
    assert [row for row, lead in enumerate(columns(scripted, "lead")[:, 0]) if lead] == [
        named[2], named[4], named[5]
    ]  # fmt: skip
    # The slab makes way for fragments that are its grandchildren, too; what does not break stays.
    assert columns(scripted, "yields")[:, 0].tolist() == [body.id == 1 for body in scripted.bodies]
    camera = frame_recording(scripted, ASPECT)
    step = float((camera.target - camera.eye) @ camera.axes[2]) / 2**17
    places = columns(scripted, "positions") * step
    first = np.concatenate([[0], np.cumsum(columns(scripted, "poses")[:, 0])])
    for body, across in ((2, -0.5), (4, 0.25), (5, 0.75)):
        assert np.allclose(places[first[named[body]]], [across, 3.0, 0.0], atol=step)
    # Without that, from an older cache, a body holds on until the next frame.
    bodies = [replace(body, before=None) for body in scripted.bodies]
    older = replace(scripted, bodies=bodies)
    assert not columns(older, "lead").any() and not columns(older, "yields").any()


def textured(recording: Recording) -> Recording:
    """With all kinds of images on every body that is not the ground."""

    def image(name: str, *colour: int) -> Image:
        data = io.BytesIO()
        Pillow.new("RGB", (4, 4), colour).save(data, "PNG")
        return Image(f"{name}.png", "image/png", data.getvalue())

    material = Material(
        (1.0, 1.0, 1.0), 0.3, 1.0, name="tiles", emission=(1.0, 0.5, 0.0),
        image=image("colour", 200, 100, 50), surface_image=image("surface", 0, 128, 255),
        normal_image=image("normal", 128, 128, 255), emission_image=image("light", 255, 255, 255),
    )  # fmt: skip
    plain = Material((0.5, 0.5, 0.5), 0.9, name="plain")

    def skin(body: Body) -> Skin:
        return Skin((plain, material), np.ones(len(body.triangles), np.int32))

    bodies = [replace(body, skin=skin(body)) if body.moves else body for body in recording.bodies]
    return replace(recording, bodies=bodies)


def test_all_images_of_a_material_are_in_the_page(scripted: Recording, tmp_path: Path) -> None:
    textured(scripted).save(tmp_path / "tiles.html")
    header, _ = blob((tmp_path / "tiles.html").read_text(encoding="utf-8"))
    (tiles,) = (one for one in header["materials"] if one["name"] == "tiles")
    kinds = ("image", "surfaceImage", "normalImage", "emissionImage")
    assert sorted(tiles[kind] for kind in kinds) == [0, 1, 2, 3]
    assert (tiles["roughness"], tiles["metallic"], tiles["emission"]) == (0.3, 1.0, [1.0, 0.5, 0.0])
    # A body without images of its own shines as in pictures.
    assert {one["roughness"] for one in header["materials"] if one["name"] != "tiles"} == {-1.0}


@needs_chromium
def test_a_browser_draws_what_has_images(wall: Recording, play: Play, tmp_path: Path) -> None:
    textured(wall).save(tmp_path / "tiles.html")
    shown = play(tmp_path / "tiles.html", [4], f"frame=4={tmp_path / 'tiles.png'}")
    assert shown["errors"] == [] and shown["requests"] == []
    with Pillow.open(tmp_path / "tiles.png") as picture:
        colours = np.asarray(picture.convert("RGB")).reshape(-1, 3).astype(int)
    # They shine in orange, which nothing else does.
    assert ((colours[:, 0] > 200) & (colours[:, 2] < 130)).sum() > 50


def test_a_page_has_the_camera_of_pictures(wall: Recording) -> None:
    inflated = inflated_of(wall)
    header = json.loads(inflated[4 : 4 + int.from_bytes(inflated[:4], "little")])
    camera = frame_recording(wall, ASPECT)
    assert header["camera"]["eye"] == camera.eye.tolist()
    assert header["camera"]["fieldOfView"] == pytest.approx(camera.fov)
    ahead = np.array(header["camera"]["target"]) - camera.eye
    assert np.allclose(ahead / np.linalg.norm(ahead), camera.axes[2])


@needs_chromium
def test_a_browser_frames_what_pictures_do(wall: Recording, play: Play, tmp_path: Path) -> None:
    wall.save(tmp_path / "wall.html")
    play(tmp_path / "wall.html", [], f"frame=0={tmp_path / 'page.png'}")
    with Pillow.open(tmp_path / "page.png") as image:
        page = np.asarray(image.convert("RGB"))

    def around(image: np.ndarray[Any, Any]) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """Middle and extents of the wall, which alone is yellowish, over the picture's width."""
        colours = image.astype(int)
        rows, columns = np.nonzero(colours[..., 0] - colours[..., 2] > 12)
        corners = np.percentile(columns, (1, 99)), np.percentile(rows, (1, 99))
        return np.mean(corners, axis=1) / 480, np.ptp(corners, axis=1) / 480

    drawn = picture(wall, 0, 480, 270)
    # The page leaves room for its controls below, some of which are yellowish, too.
    (middle, extents), (drawn_middle, drawn_extents) = around(page[:195]), around(drawn)
    shrunk = extents[0] / drawn_extents[0]
    assert 0.6 < shrunk <= 1.02
    assert extents[1] / drawn_extents[1] == pytest.approx(shrunk, rel=0.05)
    assert middle[0] - 0.5 == pytest.approx(shrunk * (drawn_middle[0] - 0.5), abs=0.02)


@needs_chromium
def test_controls_leave_a_small_picture_free(wall: Recording, play: Play, tmp_path: Path) -> None:
    wall.save(tmp_path / "wall.html")
    width, height = 360, 240
    shown = play(tmp_path / "wall.html", [], size=f"{width}x{height}")
    controls = shown["controls"]
    assert controls["left"] >= 0 and controls["right"] <= width and controls["bottom"] <= height
    assert controls["bottom"] - controls["top"] <= 0.3 * height


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
    assert shown["first"] == {
        "shot": "wall",
        "frame": "frame 0 of 60",
        "time": "0.00 s",
        "bodies": "3 bodies",
    }
    for frame, caption in zip([broken - 1, broken, 60], shown["steps"], strict=True):
        assert caption["frame"] == f"frame {frame} of 60"
        assert caption["bodies"] == f"{len(wall.alive(frame))} bodies"


@needs_chromium
def test_a_page_that_cannot_be_played_says_why(
    scripted: Recording, play: Play, tmp_path: Path
) -> None:
    scripted.save(tmp_path / "slab.html")
    page = (tmp_path / "slab.html").read_text(encoding="utf-8")
    data = re.findall(r'id="recording">([^<]*)</script>', page)[0]
    (tmp_path / "torn.html").write_text(
        page.replace(data, data[: len(data) // 2]), encoding="utf-8"
    )
    with pytest.raises(AssertionError, match="The recording cannot be played"):
        play(tmp_path / "torn.html", [1])
