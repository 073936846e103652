"""The frames of a film, drawn by several processes side by side."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
from collections import deque
from collections.abc import Generator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from queue import SimpleQueue
from typing import IO

import numpy as np
import numpy.typing as npt

from ..recording import Recording
from .camera import Camera, MovingCamera
from .picture import picture
from .shutter import CLOSED, Shutter
from .stage import Surfaces, gather_surfaces

Picture = npt.NDArray[np.uint8]

#: A process takes about as long to start as a frame to draw: it is worth it for so many.
FRAMES_EACH = 4
#: All copies of a recording together take about as much at most [bytes].
MOST_COPIES = 1 << 32
#: A process is asked for its next frame before the last one is fetched.
AHEAD = 2
#: The program of a process; its module path comes from the one that starts it.
_PROGRAM = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from frangible.render.film_processes import draw_frames; draw_frames()"
)


@dataclass(frozen=True, slots=True)
class Film:
    """Facts that all frames of a film share."""

    recording: Recording
    camera: Camera | MovingCamera
    width: int
    height: int
    shutter: Shutter = CLOSED


def film_pictures(film: Film, frames: Sequence[int]) -> Generator[Picture, None, None]:
    """The pictures (height, width, 3) of frames, in order; the same for any number of processes."""
    count = _processes(film.recording, len(frames))
    if count < 2:
        surfaces = gather_surfaces(film.recording)
        for frame in frames:
            yield draw_frame(film, frame, surfaces)
        return

    with ExitStack() as stack:
        idle: SimpleQueue[_Painter] = SimpleQueue()
        pool = stack.enter_context(ThreadPoolExecutor(count))
        # On the way out of here, also by an interrupt, processes end before their threads do.
        painters = [stack.enter_context(_Painter()) for _ in range(count)]
        data = pickle.dumps(film)
        for started in [pool.submit(painter.begin, data) for painter in painters]:
            started.result()
        for painter in painters:
            idle.put(painter)

        def draw(frame: int) -> bytes:
            painter = idle.get()
            try:
                return painter.draw(frame, 3 * film.width * film.height)
            finally:
                idle.put(painter)

        waiting: deque[Future[bytes]] = deque()
        for frame in frames:
            waiting.append(pool.submit(draw, frame))
            if len(waiting) > AHEAD * count:
                yield _shaped(waiting.popleft().result(), film)
        while waiting:
            yield _shaped(waiting.popleft().result(), film)


def draw_frame(film: Film, frame: int, surfaces: Surfaces, threads: int | None = None) -> Picture:
    """The picture (height, width, 3) of one frame."""
    return picture(
        film.recording,
        frame,
        film.width,
        film.height,
        film.camera,
        surfaces,
        threads=threads,
        shutter=film.shutter,
    )


def _shaped(pixels: bytes, film: Film) -> Picture:
    return np.frombuffer(pixels, np.uint8).reshape(film.height, film.width, 3)


def _processes(recording: Recording, frames: int) -> int:
    """How many processes are worth it."""
    # Where Python is part of another program, there is none to start.
    if not sys.executable:
        return 1
    has_affinity = hasattr(os, "sched_getaffinity")
    processors = len(os.sched_getaffinity(0)) if has_affinity else os.cpu_count() or 1
    # Poses, and a triangle with what drawing needs to know of it.
    size = sum(56 * len(body.positions) + 400 * len(body.triangles) for body in recording.bodies)
    return max(1, min(processors, frames // FRAMES_EACH, MOST_COPIES // max(size, 1)))


class _Painter:
    """A process that draws frames, until the context ends."""

    def __init__(self) -> None:
        # A group of its own: Ctrl-C is for the one that asked, which then ends this.
        self._process = subprocess.Popen(
            [sys.executable, "-c", _PROGRAM, json.dumps(sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            process_group=0,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )
        assert self._process.stdin is not None and self._process.stdout is not None
        self._orders: IO[bytes] = self._process.stdin
        self._pictures: IO[bytes] = self._process.stdout

    def __enter__(self) -> _Painter:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        with suppress(OSError):
            self._orders.close()
        self._pictures.close()

    def begin(self, film: bytes) -> None:
        """Hand over what all frames share."""
        self._send(film)

    def draw(self, frame: int, size: int) -> bytes:
        """The pixels of a frame."""
        self._send(f"{frame}\n".encode())
        pixels = self._pictures.read(size)
        if len(pixels) < size:
            raise self._ended()
        return pixels

    def _send(self, data: bytes) -> None:
        try:
            self._orders.write(data)
            self._orders.flush()
        except BrokenPipeError:
            raise self._ended() from None

    def _ended(self) -> RuntimeError:
        status = self._process.wait()
        return RuntimeError(f"a process that draws frames ended with status {status}")


def draw_frames() -> None:
    """In a process of its own: read a film and numbers of frames from stdin, write pictures to
    stdout."""
    film: Film = pickle.load(sys.stdin.buffer)
    surfaces = gather_surfaces(film.recording)
    # Each process has a processor.
    for line in sys.stdin.buffer:
        drawn = draw_frame(film, int(line), surfaces, threads=1)
        sys.stdout.buffer.write(drawn.tobytes())
        sys.stdout.buffer.flush()
