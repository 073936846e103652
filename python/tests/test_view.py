"""The player in use: what it says of a recording, live and in a notebook, and what its server
hands out."""

from __future__ import annotations

import base64
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import frangible
import numpy as np
import pytest
from frangible import Recording, World, run, shot_scene
from frangible.io.live_reel import Chunks, LiveReel
from frangible.io.page import page_of, posted_page, streaming_page
from frangible.io.page_books import gravity_of
from frangible.io.page_data import encode
from frangible.io.page_server import PageServer
from frangible.io.view_file import read_recording
from frangible.recorder import Known, Recorder
from frangible.render.camera import frame_recording
from support import ASPECT, TOOLS
from test_page import stream

CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium")
#: The first ball breaks in frame 18.
FRAMES = 24


@pytest.fixture(scope="module")
def rain() -> Recording:
    return run("rain-25", frames=FRAMES)


@contextmanager
def viewing(*arguments: str) -> Iterator[str]:
    """The address of a page that ``frangible view`` serves."""
    command = [sys.executable, "-m", "frangible", "view", *arguments, "--no-open", "--quiet"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            yield process.stdout.readline().strip()
        finally:
            process.send_signal(signal.SIGINT)
    assert process.returncode == 0


def asked(host: str, path: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
    connection = HTTPConnection(host, timeout=20)
    try:
        connection.request("GET", path, headers=headers)
        answer = connection.getresponse()
        return answer.status, dict(answer.getheaders()), answer.read()
    finally:
        connection.close()


def number(text: str) -> float:
    found = re.match(r"[-\d.e]+", text)
    assert found is not None, text
    return float(found[0])


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_a_browser_tells_what_the_recording_holds(rain: Recording, tmp_path: Path) -> None:
    rain.save(tmp_path / "rain.npz")
    (tmp_path / "book.html").write_text(f"<h1>Book</h1>{rain._repr_html_()}", encoding="utf-8")
    with (
        viewing(str(tmp_path / "rain.npz")) as recorded,
        viewing("wall", "--frames", "20") as live,
    ):
        done = subprocess.run(
            ["node", str(TOOLS / "use_player.js"), recorded, live, str(tmp_path / "book.html"),
             str(tmp_path / "rain.png")],
            capture_output=True, text=True, timeout=400,
            env={**os.environ, "CHROMIUM": CHROMIUM or ""},
        )  # fmt: skip
    assert done.returncode == 0, done.stderr
    told: dict[str, Any] = json.loads(done.stdout)
    assert told["errors"] == []
    # Nothing but the page and its chunks.
    assert set(told["requests"]) <= {recorded, live, f"{live}chunks"}

    # The piece that was picked.
    report = next(report for report in rain.reports if report["fractures"])
    assert told["broken"] == report["frame"]
    picked = told["picked"]
    piece = rain.bodies[picked["row"]]
    parent = next(body for body in rain.bodies if body.id == piece.parent)
    assert (picked["name"], picked["parent"]) == (piece.name, parent.name)
    assert number(picked["mass"]) == pytest.approx(piece.mass, rel=6e-4)
    assert picked["broke off"].startswith(f"frame {piece.birth_frame},")
    broken = next(one for one in report["fractures"] if piece.id in one["fragments"])
    striker = next(body for body in rain.bodies if body.id == broken["striker"])
    assert picked["struck by"] == striker.name
    assert number(picked["blow"]) == pytest.approx(broken["impulse"], rel=6e-3)
    row = told["broken"] + 1 - piece.birth_frame
    way = piece.positions[row] - piece.positions[row - 1]
    assert number(picked["speed"]) == pytest.approx(rain.fps * np.linalg.norm(way), rel=0.02)
    assert told["parent"]["name"] == parent.name
    assert told["parent"]["state"] == "broken"
    assert all(press["pressed"] == press["looked"] for press in told["pressed"])
    assert len({press["pressed"] for press in told["pressed"]}) == 2

    # What is said of it, and of all.
    said = told["spoken"]
    alive = len(rain.alive(told["broken"] + 1))
    assert f"frame {told['broken'] + 1} of {FRAMES}" in said and f"{alive} bodies" in said
    assert f"Picked: {piece.name}, mass" in said
    kinetic = rain.reports[told["broken"]]["energy"]["kinetic"]
    assert f"kinetic {kinetic / 1e3:.3g} kJ" in told["energy"]
    assert told["colour"] == "speed" and "m/s" in told["legend"]
    assert told["calls"] <= 12
    controls = {"view", "timeline", "play", "back", "forth", "break", "loop", "speed", "colour",
                "explode", "graph-toggle", "reset", "full", "help"}  # fmt: skip
    assert controls <= set(told["focused"])
    assert len(told["keys"]) >= 15

    assert told["live"]["frame"] == "frame 20 of 20"
    wall = run("wall", frames=20)
    assert told["live"]["bodies"] == f"{len(wall.alive(20))} bodies"
    assert "kinetic" in told["live"]["energy"]
    assert told["notebook"] == "rain-25"


def test_the_server_answers_only_who_knows_the_token(scripted: Recording) -> None:
    with PageServer(page_of(scripted)) as server:
        path = "/" + server.address.split("/", 3)[3]
        status, headers, body = asked(server.host, path)
        assert status == 200 and body.decode() == page_of(scripted)
        policy = headers["Content-Security-Policy"]
        assert "default-src 'none'" in policy and "frame-ancestors 'none'" in policy
        assert "connect-src" not in policy
        for other in ("/", "/x/", f"{path}x", f"{path}../", f"{path}chunks", path[:-1]):
            assert asked(server.host, other)[0] == 404, other
        # Another name that leads here is a page's that wants to look in.
        assert asked(server.host, path, Host="frangible.example")[0] == 403
        assert server.host.startswith("127.0.0.1:")


def test_a_streaming_page_may_ask_its_server_alone(scripted: Recording) -> None:
    blobs = [b"one", b"", b"three"]
    with PageServer(streaming_page("slab"), lambda: iter(blobs)) as server:
        path = "/" + server.address.split("/", 3)[3]
        assert "connect-src 'self'" in asked(server.host, path)[1]["Content-Security-Policy"]
        status, _, body = asked(server.host, f"{path}chunks")
    assert status == 200
    assert body == b"\x03\0\0\0one\x05\0\0\0three"


@pytest.mark.parametrize("ending", ["usdc", "glb"])
def test_files_for_other_programs_play(wall: Recording, ending: str, tmp_path: Path) -> None:
    if ending == "usdc":
        pytest.importorskip("pxr")
    path = tmp_path / f"wall.{ending}"
    wall.save(path)
    read = read_recording(str(path))
    assert read is not None
    assert (read.frames, read.fps) == (wall.frames, wall.fps)
    # The ground is a square in these files, and moves as little.
    assert len(read.bodies) == len(wall.bodies)
    lives = sorted((body.birth_frame, body.death_frame or 0) for body in wall.bodies)
    assert sorted((body.birth_frame, body.death_frame or 0) for body in read.bodies) == lives
    pieces = [body for body in wall.bodies if body.parent is not None]
    assert sum(body.parent is not None for body in read.bodies) == len(pieces)
    # Each piece is where it was: by the middle of its box, which does not depend on its frame.
    middles = np.array([middle(body, 50) for body in read.bodies if body.alive(50)])
    for piece in pieces[:5]:
        away = np.linalg.norm(middles - middle(piece, 50), axis=1)
        assert away.min() < 1e-5
    assert page_of(read)


def middle(body: Any, frame: int) -> np.ndarray[Any, Any]:
    points = body.vertices_world(frame)
    found: np.ndarray[Any, Any] = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return found


def test_what_is_no_recording_is_a_scene(tmp_path: Path) -> None:
    assert read_recording("wall") is None
    assert read_recording(str(tmp_path / "scene.json")) is None


def test_the_data_tells_masses_and_breaks(rain: Recording) -> None:
    pieces: list[bytes] = []
    encode(rain, frame_recording(rain, ASPECT), pieces.append)
    header, column = read_chunk(b"".join(pieces))
    masses = column("mass").astype(np.int32).view(np.float32)[:, 0]
    assert np.array_equal(masses, np.array([body.mass for body in rain.bodies], np.float32))
    broke = column("broke")[:, 0]
    strikers = column("break_striker")[:, 0]
    fractures = [one for report in rain.reports for one in report["fractures"]]
    for row, body in enumerate(rain.bodies):
        made = [i for i, one in enumerate(fractures) if body.id in one["fragments"]]
        assert broke[row] == (made[0] if made else -1)
    for one, striker in zip(fractures, strikers, strict=True):
        assert rain.bodies[striker].id == one["striker"]
    assert header["gravity"] == pytest.approx(-9.8, rel=1e-9)


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_panels_lie_apart_at_every_size(rain: Recording, tmp_path: Path) -> None:
    page = tmp_path / "rain.html"
    rain.save(page)
    done = subprocess.run(
        ["node", str(TOOLS / "layout.js"), str(page)], capture_output=True, text=True, timeout=300,
        env={**os.environ, "CHROMIUM": CHROMIUM or ""},
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, ""), done.stderr


#: A notebook's model, as far as a widget knows it.
MODEL = """<!doctype html><title>Book</title><body><script type="module">
import start from "data:text/javascript;base64,WIDGET";
const { page, chunks, ids, last } = STATE;
const values = { page, title: "wall", height: 380, picked: null };
const heard = { "msg:custom": [], "change:picked": [] };
const bytes = (number) => Uint8Array.from(atob(chunks[number]), (c) => c.charCodeAt(0));
const blob = (number) => new DataView(bytes(number).buffer);
const tell = (number) => heard["msg:custom"].forEach((hear) => hear({ number }, [blob(number)]));
const model = {
  get: (name) => values[name],
  set(name, value) {
    if (values[name] === value) return;
    values[name] = value;
    heard[`change:${name}`].forEach((hear) => hear());
  },
  on: (name, hear) => heard[name].push(hear),
  send({ from }) {
    asked.push(from);
    if (from > 0) for (let number = from; number < chunks.length; number++) tell(number);
  },
  save_changes() {},
};
const asked = [];
// The second chunk gets lost.
const lose = () => [2, 3].forEach(tell);
Object.assign(window, { model, asked, ids, last, lose });
const { initialize, render } = start();
initialize({ model });
render({ model, el: document.body });
tell(0);
</script>"""


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_a_notebook_plays_what_is_posted(tmp_path: Path) -> None:
    world = World.build(shot_scene("wall"), 1)
    chunks, known = Chunks(), Known()
    reel = LiveReel(chunks, known, {}, ("wall", world.method, 30.0))
    recorder = Recorder(world, None, reel, known)
    reel.send()
    ids = world.ids.tolist()
    for last in (False, False, True):
        for _ in range(4):
            recorder.capture(world.step())
        reel.send(is_last=last)
    chunks.close()
    blobs = [base64.b64encode(blob).decode() for blob in chunks.follow()]
    state = {"page": posted_page("wall"), "chunks": blobs, "ids": ids[-1:], "last": "of 12"}
    widget = (Path(frangible.__file__).parent / "live_widget.js").read_bytes()
    text = MODEL.replace("WIDGET", base64.b64encode(widget).decode())
    told = json.dumps(state).replace("</", "<\\/")
    (tmp_path / "book.html").write_text(text.replace("STATE", told), encoding="utf-8")
    done = subprocess.run(
        ["node", str(TOOLS / "use_widget.js"), str(tmp_path / "book.html")],
        capture_output=True, text=True, timeout=300, env={**os.environ, "CHROMIUM": CHROMIUM or ""},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["errors"] == []
    # All at first, then what was lost.
    assert found["asked"] == [0, 1]
    assert found["picked"] == "ball"
    assert found["next"] in set(world.ids.tolist()) - set(ids)


def test_gravity_is_told_by_frames_that_agree(rain: Recording) -> None:
    assert gravity_of(rain) == pytest.approx(-9.8, rel=1e-9)
    mixed: list[Any] = [
        {**report, "energy": {**report["energy"], "potential": i}}
        for i, report in enumerate(rain.reports)
    ]
    assert gravity_of(replace(rain, reports=mixed)) is None
    assert gravity_of(replace(rain, reports=[])) is None


def test_a_world_is_shown_as_it_is() -> None:
    world = World.build(shot_scene("wall"))
    shown = world._repr_html_()
    assert shown.startswith("<iframe") and "sandbox=" in shown
    assert zlib.crc32(world._repr_html_().encode()) == zlib.crc32(shown.encode())


def read_chunk(blob: bytes) -> tuple[dict[str, Any], Any]:
    """Header of a chunk, and what reads its streams."""
    inflated = zlib.decompress(blob)
    end = 4 + int.from_bytes(inflated[:4], "little")
    header = json.loads(inflated[4:end])
    return header, lambda name: stream(inflated[end:], header["streams"][name])


def test_chunks_hold_what_a_whole_recording_does() -> None:
    whole = run("wall", frames=20)
    world = World.build(shot_scene("wall"))
    chunks, known = Chunks(), Known()
    reel = LiveReel(chunks, known, {}, ("wall", world.method, whole.fps))
    recorder = Recorder(world, None, reel, known)
    reel.send()
    for frame in range(1, 21):
        recorder.capture(world.step())
        if frame in (1, 4, 11):
            reel.send()
    reel.send(is_last=True)
    chunks.close()

    names: list[str] = []
    lives: dict[int, list[int]] = {}
    strikers: list[int] = []
    frames = []
    for blob in chunks.follow():
        header, column = read_chunk(blob)
        names += header["names"]
        frames.append((header["first"], header["frames"], header["isLast"]))
        strikers += column("break_striker")[:, 0].tolist()
        places = column("positions") * header["steps"]["position"]
        counts = column("poses")[:, 0]
        begins = np.cumsum(counts) - counts
        for i, (row, birth, end, lead) in enumerate(
            zip(*(column(name)[:, 0] for name in ("row", "birth", "end", "lead")), strict=True)
        ):
            lives.setdefault(int(row), [int(birth), 0])[1] = int(end)
            # Every pose is that of the whole recording; the last one holds on.
            body = whole.bodies[row]
            for frame in range(birth, min(end, header["frames"] + 1)):
                at = begins[i] + min(lead + frame - birth, counts[i] - 1)
                assert np.abs(places[at] - body.pose(frame)[0]).max() <= header["steps"]["position"]
    assert frames == [(0, 0, False), (0, 1, False), (1, 4, False), (4, 11, False), (11, 20, True)]
    assert names == [body.name for body in whole.bodies]
    ends = [21 if body.death_frame is None else body.death_frame for body in whole.bodies]
    assert list(lives) == list(range(len(whole.bodies)))
    assert list(lives.values()) == [
        [body.birth_frame, end] for body, end in zip(whole.bodies, ends, strict=True)
    ]
    struck = [one["striker"] for report in whole.reports for one in report["fractures"]]
    assert [whole.bodies[row].id for row in strikers] == struck
