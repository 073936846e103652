"""Rigid bodies that break.

>>> import frangible
>>> recording = frangible.run("wall", frames=120)
>>> recording.save("wall.usdc")

Quantities are SI, y is up, quaternions are x, y, z, w.
"""

from ._frangible import (
    BuildError,
    Pattern,
    World,
    __version__,
    claims,
    mesh_info,
    patterns,
    scene_schema,
    shot_defaults,
    shot_frames,
    shot_scene,
    shots,
)
from .bench.verification import ClaimError, Finding, Verdict, verify
from .breaking.break_mesh import break_mesh
from .errors import CacheError, OutputError
from .pieces import Piece, Pieces
from .recording import Body, Recorder, Recording
from .report import StepReport
from .simulation import run

__all__ = [
    "Body",
    "BuildError",
    "CacheError",
    "ClaimError",
    "Finding",
    "OutputError",
    "Pattern",
    "Piece",
    "Pieces",
    "Recorder",
    "Recording",
    "StepReport",
    "Verdict",
    "World",
    "__version__",
    "break_mesh",
    "claims",
    "mesh_info",
    "patterns",
    "run",
    "scene_schema",
    "shot_defaults",
    "shot_frames",
    "shot_scene",
    "shots",
    "verify",
]
