"""Films: every frame of a recording, from one camera."""

from __future__ import annotations

import logging
import math
import os
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from itertools import chain

import numpy as np
import numpy.typing as npt
from PIL import Image

#: [pixels]; half of a picture's, so that a film takes minutes.
WIDTH, HEIGHT = 960, 540
#: No film shows more frames in a second; of finer steps it shows every second, third ... one.
MOST_FPS = {".mp4": 60.0, ".gif": 50.0, "": math.inf}
#: Of x264: smaller is better and larger, 18 looks like the pictures.
QUALITY = 18
#: The palette of a .gif: 256 colours, those of the film itself.
PALETTE = "split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=bayer:bayer_scale=4"

#: Called with the number of frames drawn, and of all.
FilmProgress = Callable[[int, int], None]
Picture = npt.NDArray[np.uint8]
#: Draws frames, in order.
Draw = Callable[[Sequence[int]], Generator[Picture, None, None]]


def write_film(
    path: str,
    ending: str,
    fps: float,
    frames: range,
    draw: Draw,
    progress: FilmProgress | None = None,
) -> None:
    """Write a film of some frames, ``.mp4`` or ``.gif``, or with no ending a folder of
    frame_0000.png and so on."""
    stride = max(1, math.ceil(fps / MOST_FPS[ending]))
    shown = frames[::stride]
    pictures = _told(draw(shown), len(shown), progress)
    if not ending:
        os.makedirs(path, exist_ok=True)
        digits = max(4, len(str(frames[-1])))
        for frame, image in zip(shown, pictures, strict=True):
            name = os.path.join(path, f"frame_{frame:0{digits}}.png")
            Image.fromarray(image).save(name, format="PNG")
        return
    _encode(pictures, path, ending, fps / stride)


def _told(
    drawn: Generator[Picture, None, None], count: int, progress: FilmProgress | None
) -> Iterator[Picture]:
    with closing(drawn) as pictures:
        for done, image in enumerate(pictures):
            yield image
            if progress is not None:
                progress(done + 1, count)


def _encode(pictures: Iterator[Picture], path: str, ending: str, fps: float) -> None:
    from imageio_ffmpeg import write_frames

    first = next(pictures)
    height, width = first.shape[:2]
    # It has a line of its own for a film that somebody stops.
    logging.getLogger("imageio_ffmpeg").setLevel(logging.CRITICAL)
    # The format that other programs play: even sizes and 4:2:0.
    film = write_frames(
        path,
        (width, height),
        fps=fps,
        codec="libx264" if ending == ".mp4" else "gif",
        pix_fmt_out="yuv420p" if ending == ".mp4" else "rgb8",
        macro_block_size=2 if ending == ".mp4" else 1,
        output_params=_parameters(ending),
        ffmpeg_log_level="error",
    )
    film.send(None)
    try:
        for image in chain([first], pictures):
            film.send(np.ascontiguousarray(image))
    finally:
        film.close()
    if not os.path.isfile(path) or os.path.getsize(path) == 0:
        raise OSError(0, "the encoder wrote nothing", path)


def _parameters(ending: str) -> list[str]:
    if ending == ".mp4":
        return ["-crf", str(QUALITY), "-preset", "medium", "-movflags", "+faststart"]
    return ["-vf", PALETTE, "-loop", "0"]
