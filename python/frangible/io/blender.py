"""Pictures by Blender's path tracer, Cycles, in a process of its own that is given a USD file."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec

import numpy as np
import numpy.typing as npt
from PIL import Image

from ..convention import Convention
from ..recording import Body, Recording, rotation_matrix, without_sign_flips
from ..render.camera import Camera, MovingCamera
from ..render.ground import is_half_space
from ..render.light import LAMP_COLOUR, SKY_COLOUR
from ..render.shading import HAZE_COLOUR, ZENITH_COLOUR
from ..render.shutter import Shutter
from ..render.stage import FLOOR_COLOUR, lamp_direction

Picture = npt.NDArray[np.uint8]

#: The program that Blender runs.
_PROGRAM = os.path.join(os.path.dirname(__file__), "blender_scene.py")
#: What the program begins a line with for each picture that is there.
_DONE = "FRANGIBLE PICTURE "
#: Bodies appear so long after the frame before their first one [frames]: a shutter is open for less
#: than the rest of it.
LATE = 2.0 / 64.0
#: The longest shutter [frames]: bodies have their size when it opens.
LONGEST_SHUTTER = 1.0 - 1.5 * LATE


@dataclass(frozen=True, slots=True)
class BlenderFilm:
    """Facts that all pictures share."""

    recording: Recording
    camera: Camera | MovingCamera
    width: int
    height: int
    shutter: Shutter
    #: Of a pixel.
    rays: int


def missing_blender() -> str | None:
    """How to get Blender; `None` if it is there."""
    command = _command()
    if command and shutil.which(command[0]) is None:
        return f"BLENDER_PYTHON: {command[0]}: is no program"
    if command:
        return None
    return (
        "needs Blender: `pip install bpy`, a `blender` on the PATH, or the environment variable "
        "BLENDER_PYTHON, a Python that has bpy"
    )


def _command() -> list[str]:
    """The command that runs the program; empty without Blender."""
    if python := os.environ.get("BLENDER_PYTHON"):
        return [python, "-P", _PROGRAM]
    if sys.executable and find_spec("bpy") is not None:
        return [sys.executable, "-P", _PROGRAM]
    if blender := shutil.which("blender"):
        return [blender, "--background", "--factory-startup", "--python", _PROGRAM, "--"]
    return []


def write_blender_png(film: BlenderFilm, path: str, frame: int) -> None:
    """Write a picture of a frame."""
    (image,) = blender_pictures(film, [frame])
    Image.fromarray(image).save(path, format="PNG")


def blender_pictures(film: BlenderFilm, frames: Sequence[int]) -> Generator[Picture, None, None]:
    """The pictures (height, width, 3) of frames, in order; `RuntimeError` if Blender fails."""
    from .usd import write_usd

    with tempfile.TemporaryDirectory() as folder:
        stage = os.path.join(folder, "recording.usdc")
        write_usd(shown_to_shutter(film.recording), stage, late=LATE)
        job = os.path.join(folder, "job.json")
        with open(job, "w", encoding="utf-8") as file:
            json.dump(_job(film, frames, stage, folder), file)
        errors = os.path.join(folder, "errors.txt")
        with open(errors, "wb") as stderr:
            # A group of its own: Ctrl-C is for the one that asked, which then ends this.
            process = subprocess.Popen(
                [*_command(), job],
                stdout=subprocess.PIPE,
                stderr=stderr,
                text=True,
                errors="replace",
                process_group=0,
                # What it leaves behind goes away with the folder.
                env={**os.environ, "TMPDIR": folder},
            )
        assert process.stdout is not None
        done = 0
        try:
            for line in process.stdout:
                if line.startswith(_DONE):
                    with Image.open(line.removeprefix(_DONE).strip()) as image:
                        yield np.asarray(image.convert("RGB"))
                    done += 1
        finally:
            process.kill()
            status = process.wait()
            process.stdout.close()
        if done < len(frames):
            with open(errors, encoding="utf-8", errors="replace") as said:
                last = (said.read().strip().splitlines() or [f"status {status}"])[-1]
            raise RuntimeError(f"Blender drew {done} of {len(frames)} pictures, then: {last}")


def shown_to_shutter(recording: Recording) -> Recording:
    """The same recording, each body a frame earlier: where it was as a part of its parent, which
    makes room for it. So bodies that a frame shows move all the time up to it. Half-spaces are left
    out, and the stage is in metres, y up."""
    bodies = [_early(body) for body in recording.bodies if not is_half_space(body)]
    return replace(recording, bodies=bodies, convention=Convention())


def _early(body: Body) -> Body:
    death = None if body.death_frame is None else body.death_frame - 1
    if body.birth_frame == 0:
        return replace(body, death_frame=death)
    now = np.concatenate([body.positions[0], body.orientations[0]])
    before = now if body.before is None else body.before
    return replace(
        body,
        birth_frame=body.birth_frame - 1,
        death_frame=death,
        positions=np.concatenate([before[None, :3], body.positions]),
        orientations=without_sign_flips(np.concatenate([before[None, 3:], body.orientations])),
    )


def _job(film: BlenderFilm, frames: Sequence[int], stage: str, folder: str) -> dict[str, object]:
    moves = isinstance(film.camera, MovingCamera)
    # A moving camera's shutter needs the frame before.
    times = sorted({time for frame in frames for time in (frame - 1, frame)}) if moves else [0]
    first = film.camera.at(0).first or film.camera.at(0)
    floors = []
    for body in film.recording.bodies:
        if is_half_space(body):
            position, turn = body.pose(body.birth_frame)
            up = rotation_matrix(turn)[:, 1]
            middle = first.target - ((first.target - position) @ up) * up
            floors.append({"middle": middle.tolist(), "normal": up.tolist()})
    return {
        "stage": stage,
        "folder": folder,
        "frames": list(frames),
        "size": [film.width, film.height],
        "rays": film.rays,
        "shutter": min(film.shutter.degrees / 360.0, LONGEST_SHUTTER),
        "cameras": [_camera(film.camera.at(time), time) for time in times],
        "distance": float(np.linalg.norm(first.target - first.eye)),
        "lamp": lamp_direction(first).tolist(),
        "lamp_colour": LAMP_COLOUR.tolist(),
        "sky_colour": SKY_COLOUR.tolist(),
        "haze": HAZE_COLOUR.tolist(),
        "zenith": ZENITH_COLOUR.tolist(),
        "floors": floors,
        "floor_colour": FLOOR_COLOUR.tolist(),
    }


def _camera(camera: Camera, time: int) -> dict[str, object]:
    """Rows of `axes` are right, up and forward."""
    return {
        "time": time,
        "eye": camera.eye.tolist(),
        "axes": camera.axes.tolist(),
        "half_height": camera.half_height,
    }
