"""Films: whole files of the right size, length and rate, from one camera."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frangible import OutputError, Recording
from frangible.cli import main
from frangible.io.drawing import View
from frangible.io.output import open_output
from frangible.render import film_processes
from frangible.render.camera import frame_recording
from frangible.render.film import _encode
from frangible.render.film_processes import Film, film_pictures
from PIL import Image

SIZE = (64, 36)


def test_an_mp4_has_every_frame(scripted: Recording, tmp_path: Path) -> None:
    from imageio_ffmpeg import count_frames_and_secs, read_frames

    path = tmp_path / "slab.mp4"
    open_output(str(path), view=View(size=SIZE)).write(scripted)
    count, seconds = count_frames_and_secs(str(path))
    assert (count, round(seconds * scripted.fps)) == (scripted.frames + 1, scripted.frames + 1)
    assert next(read_frames(str(path)))["size"] == SIZE
    assert os.listdir(tmp_path) == ["slab.mp4"]


def test_a_gif_has_every_frame_and_goes_on(scripted: Recording, tmp_path: Path) -> None:
    path = tmp_path / "slab.gif"
    open_output(str(path), view=View(size=SIZE)).write(scripted)
    with Image.open(path) as film:
        assert (film.n_frames, film.size, film.info["loop"]) == (scripted.frames + 1, SIZE, 0)


def test_a_folder_holds_the_pictures_of_one_camera(scripted: Recording, tmp_path: Path) -> None:
    from frangible.render.picture import picture

    output = open_output(f"{tmp_path}/frames/", view=View(size=SIZE))
    output.write(scripted)
    names = sorted(os.listdir(tmp_path / "frames"))
    assert names == [f"frame_{frame:04}.png" for frame in range(scripted.frames + 1)]
    camera = frame_recording(scripted, 64 / 36)
    with Image.open(tmp_path / "frames" / "frame_0004.png") as image:
        assert np.array_equal(np.asarray(image), picture(scripted, 4, *SIZE, camera))
    # A second film takes the first one's place.
    open_output(f"{tmp_path}/frames/", view=View(size=SIZE)).write(scripted)
    assert os.listdir(tmp_path) == ["frames"]


def test_a_folder_with_anything_else_stays(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("dear")
    with pytest.raises(OutputError, match="letter.txt"):
        open_output(f"{tmp_path}/")


@pytest.mark.parametrize("ending", [".mp4", ".gif", "/"])
def test_an_interrupted_film_leaves_nothing(
    ending: str, scripted: Recording, tmp_path: Path
) -> None:
    def interrupt(done: int, _: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    output = open_output(f"{tmp_path}/slab{ending}", view=View(size=SIZE, progress=interrupt))
    with pytest.raises(KeyboardInterrupt):
        output.write(scripted)
    assert os.listdir(tmp_path) == []


def test_a_cache_is_drawn_without_simulating(scripted: Recording, tmp_path: Path) -> None:
    cache, path, again = (tmp_path / name for name in ("slab.npz", "slab.png", "again.npz"))
    scripted.save(cache)
    out = ["--out", str(path), "--out", str(again), "--frame", "3", "--size", "64x36", "--quiet"]
    assert main(["render", str(cache), *out]) == 0
    with Image.open(path) as image:
        assert image.size == SIZE
    assert Recording.load(again).frames == scripted.frames


def test_processes_draw_what_one_does(wall: Recording, monkeypatch: pytest.MonkeyPatch) -> None:
    film = Film(wall, frame_recording(wall, 64 / 36), *SIZE)
    shown = range(0, 24, 2)
    pictures = {}
    for count in (1, 3):
        monkeypatch.setattr(film_processes, "_processes", lambda *_, count=count: count)
        pictures[count] = list(film_pictures(film, shown))
    assert len(pictures[3]) == len(shown)
    assert all(np.array_equal(*both) for both in zip(pictures[1], pictures[3], strict=True))


def test_no_process_outlives_a_film(scripted: Recording, monkeypatch: pytest.MonkeyPatch) -> None:
    started = []

    class Counted(subprocess.Popen):  # type: ignore[type-arg]
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            started.append(self)

    monkeypatch.setattr("frangible.render.film_processes.subprocess.Popen", Counted)
    monkeypatch.setattr(film_processes, "_processes", lambda *_: 2)
    film = Film(scripted, frame_recording(scripted, 64 / 36), *SIZE)
    pictures = film_pictures(film, range(scripted.frames + 1))
    next(pictures)
    assert [process.poll() for process in started] == [None, None]
    pictures.close()
    assert [process.poll() for process in started] == [-signal.SIGKILL] * 2
    # One that ends by itself is told of.
    pictures = film_pictures(film, range(scripted.frames + 1))
    next(pictures)
    started[-1].kill()
    started[-2].kill()
    with pytest.raises(RuntimeError, match="ended with status -9"):
        list(pictures)


def test_ctrl_c_ends_a_film_at_once(wall: Recording, tmp_path: Path) -> None:
    wall.save(tmp_path / "wall.npz")
    command = [sys.executable, "-m", "frangible", "render", "wall.npz", "--size", "256x144"]
    command += ["--out", "wall.mp4"]
    run = subprocess.Popen(
        command, cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    assert run.stderr is not None
    assert run.stderr.readline().startswith("drawing wall.mp4")
    # As a terminal does, to all of the group.
    os.killpg(run.pid, signal.SIGINT)
    rest = run.communicate(timeout=20)[1]
    assert run.returncode == 130
    assert rest.splitlines()[-1] == "frangible: interrupted" and "Traceback" not in rest
    assert os.listdir(tmp_path) == ["wall.npz"]


@pytest.mark.parametrize("size", ["64", "64x", "0x0", "65x36", "99999x36", "x"])
def test_a_wrong_size_is_a_sentence(size: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["render", "none.npz", "--out", "a.png", "--size", size])
    assert "must be" in capsys.readouterr().err


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_a_floor_has_no_speckles(scale: float, scripted: Recording) -> None:
    from dataclasses import replace

    from frangible.render.picture import picture

    cube = scripted.body(5)
    turn = np.array([0.0, 0.0, -0.2, np.sqrt(1.0 - 0.04)])
    ground = replace(
        cube, id=9, source=9, parent=None, birth_frame=0, death_frame=None, mass=np.inf, look=None,
        vertices=np.zeros((0, 3), np.float32), triangles=np.zeros((0, 3), np.uint32),
        interior=np.zeros(0, np.bool_), coordinates=np.zeros((0, 3, 2), np.float32),
        positions=np.zeros((7, 3)), orientations=np.tile(turn, (7, 1)),
    )  # fmt: skip
    small = replace(
        cube, id=8, source=8, parent=None, birth_frame=0, look=None,
        vertices=cube.vertices * np.float32(scale), positions=np.full((7, 3), 1.0) * scale,
        orientations=np.tile([0.0, 0.0, 0.0, 1.0], (7, 1)),
    )  # fmt: skip
    image = picture(replace(scripted, bodies=[ground, small]), 0, 320, 180).astype(int)
    # Far from the cube the floor changes smoothly, apart from faint lines.
    floor = image[120:, :80].sum(axis=2)
    assert np.abs(np.diff(floor, axis=1)).max() < 90


def test_a_film_that_is_stopped_says_nothing_of_its_own(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    def stopped() -> Iterator[np.ndarray]:
        raise KeyboardInterrupt
        yield

    with pytest.raises(KeyboardInterrupt):
        _encode(stopped(), str(tmp_path / "a.mp4"), ".mp4", 30.0)
    assert capfd.readouterr().err == "" and not caplog.records


def test_progress_says_how_long_the_rest_takes(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from frangible.cli import outputs

    clock = iter(range(100))
    monkeypatch.setattr(outputs.time, "monotonic", lambda: float(next(clock)))
    tell = outputs._progress("a.mp4")
    for done in range(1, 31):
        tell(done, 30)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "drawing a.mp4: 10 %, 27 s left"
    assert lines[-1] == "drawing a.mp4: 100 %, 0 s left"
    assert len(lines) == 10
    # A picture may be done at once.
    outputs._progress("a.png")(1, 1)
    assert capsys.readouterr().err == "drawing a.png: 100 %\n"
    # On a terminal one line changes.
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    for done in (10, 30):
        tell(done, 30)
    seen = capsys.readouterr().err
    assert seen.count("\n") == 1 and seen.count("\r") == 2
