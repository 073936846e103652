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
    shot_defaults,
    shot_frames,
    shot_scene,
    shots,
)
from .bench.verification import ClaimError, Finding, Verdict, verify
from .breaking.break_mesh import break_mesh
from .errors import CacheError, OutputError
from .pieces import Piece, Pieces
from .recording import Body as RecordedBody
from .recorder import Recorder
from .recording import Recording
from .report import StepReport
from .scene_file import Scene
from .scene_schema import scene_schema
from .scene_types import (
    Anchor,
    Body,
    Bonds,
    Box,
    BoxPart,
    Breaking,
    Bricks,
    Capsule,
    Compound,
    Concrete,
    Cone,
    Cylinder,
    HalfSpace,
    Heightfield,
    Hull,
    HullPart,
    Keyframe,
    Mass,
    Material,
    Mesh,
    Natural,
    OwnLook,
    PatternFile,
    Radial,
    Resolution,
    Slices,
    Solver,
    Sphere,
    Splinters,
    Starts,
    Strength,
    StrengthPoint,
    Surface,
    Triangles,
    Voronoi,
)
from .simulation import run

__all__ = [
    "Anchor",
    "Body",
    "Bonds",
    "Box",
    "BoxPart",
    "Breaking",
    "Bricks",
    "BuildError",
    "CacheError",
    "Capsule",
    "ClaimError",
    "Compound",
    "Concrete",
    "Cone",
    "Cylinder",
    "Finding",
    "HalfSpace",
    "Heightfield",
    "Hull",
    "HullPart",
    "Keyframe",
    "Mass",
    "Material",
    "Mesh",
    "Natural",
    "OutputError",
    "OwnLook",
    "Pattern",
    "PatternFile",
    "Piece",
    "Pieces",
    "Radial",
    "RecordedBody",
    "Recorder",
    "Recording",
    "Resolution",
    "Scene",
    "Slices",
    "Solver",
    "Sphere",
    "Splinters",
    "Starts",
    "StepReport",
    "Strength",
    "StrengthPoint",
    "Surface",
    "Triangles",
    "Verdict",
    "Voronoi",
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
