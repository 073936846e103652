"""The engine, compiled from Rust. Quantities are SI, y is up, quaternions are x, y, z, w."""

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, final

import numpy as np
import numpy.typing as npt

from .bench.verification import Finding
from .breaking.cleaning import CleanMesh
from .pieces import Contact
from .report import StepReport
from .scene_types import Body, SceneDesc

__all__ = [
    "BuildError",
    "MOST_TRIANGLES",
    "Pattern",
    "World",
    "__version__",
    "break_mesh_on_grid",
    "check_claim",
    "claims",
    "clean_mesh",
    "closest_triangles",
    "decode_meshopt",
    "join_slivers",
    "load_mesh",
    "mesh_attributes",
    "mesh_info",
    "mesh_mass",
    "pattern_cutters",
    "patterns",
    "piece_contacts",
    "resurface",
    "scene_schema",
    "shot_defaults",
    "shot_frames",
    "shot_scene",
    "shots",
    "thicken_mesh",
]

__version__: str

MOST_TRIANGLES: int
"""The most triangles of a mesh file, its instances counted one by one."""

_memory_kept_ms: int
"""How long freed memory is kept for the next frame [ms]; `MIMALLOC_PURGE_DELAY` in the environment
says otherwise."""

class BuildError(ValueError):
    """A scene that cannot be built: the message names the field, the value and the rule."""

def shots() -> list[tuple[str, str]]:
    """Name and one line for every built-in shot."""

def shot_defaults() -> dict[str, Any]:
    """What `shot_scene` takes for `fps`, `method` and `seed` if it is given `None`."""

def shot_frames(name: str, fps: float | None = None) -> int:
    """How many frames a shot takes at `fps` frames per second; `BuildError` for an unknown name."""

def shot_scene(
    name: str,
    *,
    mesh: str | None = None,
    fps: float | None = None,
    method: str | None = None,
    seed: int | None = None,
    thickness: float | None = None,
) -> str:
    """The scene of a shot, as JSON; `BuildError` for an unknown name or method, or a mesh that
    cannot be used.

    Open parts of a mesh become plates of a ``thickness``, in the file's unit.

    `shot_defaults` says what stands for `None`.
    """

def scene_schema() -> dict[str, Any]:
    """The JSON Schema of scenes, made from their descriptions in Rust."""

def claims() -> list[tuple[str, str, str]]:
    """Name, what is promised and who says so, for every claim."""

def check_claim(name: str) -> list[Finding]:
    """Measure a claim, on one thread and without the interpreter lock; `KeyError` for an unknown
    name."""

def patterns() -> list[tuple[str, str]]:
    """Name and one line for every kind of pattern."""

@final
class Pattern:
    """A box broken into cells, around its fracture centre. Lengths are in a unit of its own; z is
    the collision normal."""

    @staticmethod
    def named(name: str, *, cells: int | None = None, seed: int | None = None) -> Pattern:
        """A kind that `patterns` lists, with about so many cells, or one from a file if the name
        has an ending.

        `BuildError` if there is none of this name, or a number is out of its range.
        """

    @staticmethod
    def load(path: str) -> Pattern:
        """Read a pattern from a file; `BuildError` says what is wrong with it."""

    def with_pieces(
        self,
        pieces: int,
        mesh: tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]] | None = None,
        at: Sequence[float] = ...,
        normal: Sequence[float] = ...,
        voxels: int = 48,
        smallest_voxels: float = 27.0,
    ) -> tuple[Pattern, int]:
        """The pattern, finer, coarser or larger, that breaks a mesh into about so many pieces, and
        how many it is on a grid of so many voxels along the mesh's longest side. Without a mesh:
        with so many cells.

        A pattern from a file has the cells that it has, and can be laid on the mesh larger, not
        smaller.
        """

    def with_pieces_by(
        self,
        pieces: int,
        attempt: Callable[[Pattern], int],
        mesh: tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]] | None = None,
        at: Sequence[float] = ...,
        normal: Sequence[float] = ...,
        number: int = 0,
    ) -> tuple[Pattern, int]:
        """As `with_pieces`, where ``attempt`` breaks something with a pattern, and says how many
        pieces there are. With a closed mesh the patterns are made for it, for each ``number``
        another one."""

    @property
    def has_middle(self) -> bool:
        """True if its cells lie around the blow and nowhere else: spokes, and those of a file."""

    def save(self, path: str) -> None:
        """Write a file that `load` makes an equal pattern of; `BuildError` if it cannot be
        written."""

    def __len__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    @property
    def half_extent(self) -> npt.NDArray[np.float64]:
        """(3,) half of the box's edge lengths."""

    @property
    def is_planar(self) -> bool:
        """True if all cells are polyhedra."""

    def is_joint(self, cell: int) -> bool:
        """Whether a cell is mortar between others; `IndexError` if there is no such cell."""

    def region_mesh(
        self, cell: int, longest_edge: float = ...
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]:
        """The closed surface of a cell: vertices (v, 3) and triangles (t, 3); `IndexError` if there
        is no such cell."""

    def shapes(
        self,
    ) -> tuple[
        npt.NDArray[np.uint32],
        npt.NDArray[np.uint32],
        npt.NDArray[np.float64],
        npt.NDArray[np.bool_],
    ]:
        """Of each cell (n,): its faces, its corners, its volume, and whether it touches no wall of
        the box.

        Cells with rough faces count as the plane ones behind them.
        """

def mesh_info(path: str) -> dict[str, Any]:
    """What a mesh file holds; `BuildError` if it cannot be read.

    `unit_inertia_m5` is the tensor (3, 3) about `center_m` at unit density: times kg/m^3 it is in
    kg m^2.
    """

def decode_meshopt(data: bytes, count: int, stride: int, mode: str, filter: str) -> bytes:
    """`count` rows of `stride` bytes from a compressed view of a glTF file; `BuildError`, to follow
    the view's name."""

def load_mesh(path: str) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]:
    """Vertices (v, 3) [m] and triangles (t, 3) of a mesh file; `BuildError` if it cannot be
    read."""

def mesh_attributes(path: str) -> dict[str, Any] | None:
    """Attributes of a mesh file's triangles (t,); `None` if it says nothing.

    `corners` (t, 3, 3) [m]; `object` (t,), index into `objects`, each a list of names, the root's
    first; `material` (t,), index into `materials`: names in OBJ, numbers in glTF; -1 is none.
    `coordinates` (t, 3, 2) with v up, `normals` (t, 3, 3), unit, and `colours` (t, 3, 4), linear,
    of the corners; NaN where there is nothing. `BuildError` if the file cannot be read.
    """

def closest_triangles(
    corners: npt.NDArray[np.float64],
    groups: npt.NDArray[np.int64],
    points: npt.NDArray[np.float64],
    normals: npt.NDArray[np.float64],
    wanted: npt.NDArray[np.int64],
    reach: npt.NDArray[np.float64],
) -> npt.NDArray[np.int64]:
    """For each point (n, 3) the index of the closest of triangles (t, 3, 3) of groups (t,): of the
    `wanted` group (n,), -1 for any. One that faces to the side of the point's normal (n, 3) comes
    first, unless it is farther away by its `reach` (n,)."""

def clean_mesh(
    mesh: tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]], name: str = ...
) -> CleanMesh:
    """The solids that raw triangles bound, part by part: welded, repeated triangles dropped, turned
    to agree, holes closed, open flat parts left out. `BuildError` if no part encloses a volume."""

def thicken_mesh(
    mesh: tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]], thickness: float, name: str = ...
) -> tuple[tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]], int]:
    """Raw triangles with a plate of a thickness [m] in place of each open part, and their number:
    its triangles moved by half of that to both sides along the normals of their vertices, and walls
    along its rims. `BuildError` if the thickness is not above zero."""

def resurface(
    mesh: tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]], voxels: int
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]:
    """The surface of what a mesh encloses made anew, closed and free of crossings, on a grid of so
    many voxels along the longest side; `BuildError` if the grid does not resolve it."""

def mesh_mass(mesh: tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]]) -> dict[str, Any]:
    """`volume_m3`, `center_m` (3) and `unit_inertia_m5` (3, 3) about it, of what a closed mesh
    encloses."""

def join_slivers(
    volumes: list[float], contacts: list[tuple[list[int], float]], smallest: float
) -> list[int]:
    """For each piece the number of the one that it joins, its own for most, so that none is smaller
    than `smallest` of the mean.

    `contacts` are pairs of pieces and areas [m^2]: a piece joins the neighbour that it touches over
    the largest.
    """

def piece_contacts(
    pieces: list[
        tuple[tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]], npt.NDArray[np.bool_]]
    ],
) -> list[Contact]:
    """Contacts of pieces that were cut out of a mesh: for each the surface, and whether a crack
    made each triangle (t,)."""

def pattern_cutters(
    pattern: Pattern,
    bounds: tuple[Sequence[float], Sequence[float]],
    at: Sequence[float],
    normal: Sequence[float],
    coarseness: float = 1.0,
) -> list[tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32], npt.NDArray[np.uint32]]]:
    """The cells of a pattern, laid onto the box of a mesh (lowest and highest corner [m]) that is
    struck at a point: for each its closed surface, and for each triangle the face that it is a part
    of: a plane, or a rough crack towards one neighbour. Cells beside the box are empty; triangles
    of rough ones are larger by the ``coarseness``."""

def break_mesh_on_grid(
    pattern: Pattern,
    mesh: tuple[npt.NDArray[np.float64], npt.NDArray[np.uint32]],
    at: Sequence[float],
    normal: Sequence[float],
    voxels: int,
    smallest: float = ...,
) -> dict[str, Any]:
    """Break a mesh on a grid of so many voxels along its longest side: `volume_m3` of it there,
    `pieces` and `contacts`.

    Parts smaller than `smallest` of the mean piece join a neighbour.

    A piece has what `mesh_mass` says, and `vertices` (v, 3) [m], `triangles` (t, 3), `inner` (t,):
    whether a crack made each, and texture `coordinates` (t, 3, 2) of their corners [m].
    """

@final
class World:
    """Bodies, and the engine that moves and breaks them.

    Arrays are copies with one row for each living body; a body keeps its id as long as it lives.
    One thread at a time may use a world (`RuntimeError`); a forked child may go on with a copy of
    its parent's.
    """

    @staticmethod
    def build(
        scene: str | os.PathLike[str] | dict[str, Any] | SceneDesc, threads: int = 0
    ) -> World:
        """Check a scene and build it: a `frangible.Scene`, JSON, a dictionary, or a file's path,
        which ends in .json, .toml or .py, or has a folder.

        0 threads means one for every processor. `BuildError` if a rule is broken: path, value and
        rule.
        """

    @property
    def volumes(self) -> npt.NDArray[np.float64]:
        """(n,) [m^3]; 0 for bodies without a volume."""

    def snapshot(self) -> bytes:
        """All of the state, for `restore`."""

    @staticmethod
    def restore(snapshot: bytes, threads: int = 0) -> World:
        """The world of a snapshot, whose next frames are those of the world that wrote it, to the
        bit.

        `BuildError` if the bytes are not those of a snapshot of this version.
        """

    def step(self) -> StepReport:
        """Advance by one frame, without the interpreter lock, and report on it.

        A signal whose handler raises, as Ctrl-C, ends it: the world is as it was before.
        """

    def stop_step(self) -> None:
        """End the step that another thread or a handler of signals sees running, or else the next
        one, with `KeyboardInterrupt`: the world is as it was before."""

    @property
    def frame(self) -> int:
        """Number of steps so far."""

    @property
    def time(self) -> float:
        """[s]."""

    @property
    def dt(self) -> float:
        """Length of a frame [s]."""

    @property
    def method(self) -> str:
        """Which step advances a frame."""

    @property
    def energy(self) -> tuple[float, float]:
        """Kinetic and potential energy of all dynamic bodies now [J]."""

    @property
    def ids(self) -> npt.NDArray[np.uint64]:
        """(n,) ids of the living bodies."""

    @property
    def positions(self) -> npt.NDArray[np.float64]:
        """(n, 3) centres of mass, world frame [m]."""

    @property
    def orientations(self) -> npt.NDArray[np.float64]:
        """(n, 4) `world_from_body`, unit quaternions."""

    @property
    def velocities(self) -> npt.NDArray[np.float64]:
        """(n, 3) of the centres of mass, world frame [m/s]."""

    @property
    def angular_velocities(self) -> npt.NDArray[np.float64]:
        """(n, 3) world frame [rad/s]."""

    @property
    def masses(self) -> npt.NDArray[np.float64]:
        """(n,) [kg]; infinite for static and kinematic bodies. Of a body that waits, the mass that
        it starts with."""

    @property
    def asleep(self) -> npt.NDArray[np.bool_]:
        """(n,) whether each slept in the last frame, where the scene has ``"sleep": true``."""

    @property
    def waiting(self) -> npt.NDArray[np.bool_]:
        """(n,) whether each waits for its start: a body with ``starts``."""

    def start(self, id: int) -> bool:
        """Start a body that waits, with its initial velocities, from the next step on. False if it
        does not wait."""

    @property
    def names(self) -> list[str]:
        """(n) names."""

    @property
    def parents(self) -> list[int | None]:
        """(n) id of the body that each fragment broke off from, `None` for the bodies of the
        scene."""

    @property
    def looks(self) -> list[str | None]:
        """(n) what each body is drawn as: glass, concrete, brick, mortar, wood, stone or metal;
        `None` if nobody said."""

    def material_frame(self, id: int) -> tuple[list[float], list[float]]:
        """The frame of a body's material, which is a mesh's own in metres, seen from its body
        frame: origin [m] and quaternion.

        Fragments keep that of the body that they broke off from. `KeyError` if no living body has
        the id.
        """

    def add_body(self, body: Mapping[str, Any] | Body) -> int:
        """Add a body as a scene would hold it, behind all others; its id.

        It may have a preset's material, or one of the scene's own; what it brings of energy and
        momentum belongs to no step and no report. `BuildError` for the first rule that it breaks.
        """

    def remove_body(self, id: int) -> None:
        """Take a living body out, with its energy and momentum; `BuildError` if it is gone."""

    def set_velocity(self, id: int, linear: npt.ArrayLike, angular: npt.ArrayLike) -> None:
        """Give a dynamic or kinematic body a velocity, (3) each [m/s, rad/s], in the world frame.

        A kinematic body keeps it until it gets another. `BuildError` if the body lives no longer or
        is static or waits, or a number is not finite.
        """

    def apply_impulse(self, id: int, impulse: npt.ArrayLike, point: npt.ArrayLike) -> float:
        """Give a dynamic body an impulse (3) [N s] at a point (3) [m], both in the world frame.

        Returns its work [J], which the next report counts as such. `BuildError` if the body lives
        no longer, is not dynamic or waits, or would become too fast.
        """

    def hold(
        self, id: int, point: npt.ArrayLike, target: npt.ArrayLike, force: float
    ) -> None:
        """Pull a point (3) of a dynamic body's own frame to a target (3) in the world frame [m].

        In each frame, with at most so much force [N], until `let_go`, or until the body breaks.
        Reports count the work. Holding a body again moves the hand. `BuildError` as for
        `apply_impulse`.
        """

    def let_go(self, id: int) -> bool:
        """Let go of a body; False if it is not held."""

    def cut(self, id: int, point: npt.ArrayLike, normal: npt.ArrayLike) -> list[int]:
        """Cut a body along the plane through a point (3) [m], across a normal (3), world frame.

        Returns its pieces, none if the plane does not part it. They have its mass and motion, and
        break as it would have. Of a glued body the bonds give way whose pieces lie on both sides.
        `BuildError` if the body lives no longer, waits or cannot be cut.
        """

    def burst(self, id: int, point: npt.ArrayLike, speed: float = 0.0) -> list[int]:
        """Break a body by its pattern, as a blow at a point (3) of its surface would [m].

        Sends the pieces apart, the farthest with `speed` [m/s], without a change of momentum.
        Returns them. A glued body loses all bonds. `BuildError` if the body lives no longer, waits
        or is unbreakable.
        """

    def surface(
        self, id: int
    ) -> tuple[
        npt.NDArray[np.float32],
        npt.NDArray[np.uint32],
        npt.NDArray[np.bool_],
        npt.NDArray[np.float32],
    ]:
        """Vertices (v, 3) in the body frame [m], triangles (t, 3), whether a crack made each (t,),
        and texture coordinates.

        The coordinates (t, 3, 2) of the triangles' corners are metres: of a crack in its own plane,
        of all else along the axes of the body's material.

        `KeyError` if no living body has the id.
        """

    def penetrations(self) -> npt.NDArray[np.float64]:
        """(k,) how deep each overlapping pair of bodies is now [m]; found without the interpreter
        lock."""

    def state_hash(self) -> str:
        """Hexadecimal digest of the whole state: equal states have equal hashes."""

    def _repr_html_(self) -> str:
        """The world as it is now, for a notebook: a page that shows it from all sides."""
