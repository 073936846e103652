"""Meshes of USD files, and of glTF files as they are shipped: handed to the core as a mesh file
that it reads."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .._frangible import MOST_TRIANGLES, BuildError
from ..extras import missing_packages
from ..recording import Float64, Int64
from .gltf_mesh import ENDINGS as GLTF_ENDINGS
from .gltf_mesh import make_plain
from .reading import FileNote, file_fault
from .usd_part import Part

#: What USD files end in.
ENDINGS = (".usd", ".usda", ".usdc", ".usdz")

#: The most points of a stage, its instances counted one by one: of triangles without neighbours.
MOST_POINTS = 3 * MOST_TRIANGLES
#: The most meshes, shapes and instances of them: some ten seconds.
MOST_PARTS = 200_000


def check_ending(path: str | os.PathLike[str]) -> None:
    """`BuildError` unless the file's ending is that of a mesh file."""
    ending = os.path.splitext(os.fspath(path))[1].lower()
    known = (".obj", ".ply", ".stl", *GLTF_ENDINGS, *ENDINGS)
    if ending not in known:
        rule = f"must end in one of {', '.join(known)}"
        raise BuildError(f"{os.fspath(path)}: ends in {ending!r}, {rule}")


@contextmanager
def readable_mesh(path: str | os.PathLike[str], pose_time: float | None = None) -> Iterator[str]:
    """The path itself, or for a USD or glTF file that of a plain mesh file that the core reads,
    while the context lasts.

    USD is read whole, with lengths in metres and y up; of glTF what is packed is unpacked. What
    moves is where it is at the beginning or, if that is given, ``pose_time`` [s] after it.
    `BuildError` if there is no mesh, or a package for it is missing; `FileNote` warnings name what
    is left out.
    """
    path = os.fspath(path)
    ending = os.path.splitext(path)[1].lower()
    if ending not in (*ENDINGS, *GLTF_ENDINGS) or file_fault(path):
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        name = os.path.join(
            folder, f"{os.path.basename(path)}{'.obj' if ending in ENDINGS else '.glb'}"
        )
        if ending in ENDINGS:
            _convert(path, name, pose_time)
        elif not make_plain(path, name, pose_time):
            name = path
        try:
            yield name
        except BuildError as error:
            raise BuildError(str(error).replace(name, path)) from None


def _convert(path: str, obj: str, pose_time: float | None) -> None:
    """Write all meshes and shapes of a stage that are visible and no guides."""
    if hint := missing_packages("usd"):
        raise BuildError(f"{path}: {hint}")
    from .usd_stage import metres_from_stage, open_stage, time_code

    with open_stage(path) as stage:
        reader = _Reader(path, time_code(stage, pose_time), is_posed=pose_time is not None)
        units = np.eye(4)
        units[:3, :3] = metres_from_stage(path, stage).T
        parts = [_moved(part, units) for part in reader.gather(stage.GetPseudoRoot())]
        notes = [*_missing(stage), *reader.left_out_parts()]
        if not any(len(part.counts) for part in parts):
            raise BuildError("; ".join([f"{path}: has no mesh that can be seen", *notes]))
        _write_obj(obj, parts, reader.time)
    for note in notes:
        warnings.warn(f"{path}: {note}", FileNote, stacklevel=2)


@dataclass(slots=True)
class _Reader:
    path: str
    time: Any
    #: True if somebody asked for that time, at which skeletons would have moved.
    is_posed: bool
    #: Points, triangles and parts that were made so far.
    points: int = 0
    triangles: int = 0
    parts: int = 0
    #: The parts of each prototype, by its path; `None` while it is read.
    prototypes: dict[str, list[Part] | None] = field(default_factory=dict)
    #: The library's cache of skeletons.
    skeletons: Any = None
    #: First prim of each kind that is left out, and how many there are.
    left_out: dict[str, tuple[str, int]] = field(default_factory=dict)

    def gather(self, root: Any) -> list[Part]:
        """The parts of a prim and below it, in the frame of the root or, for a prototype, of its
        parent."""
        from pxr import Usd, UsdGeom

        # Prototypes may be `over`, so that they are seen as instances only.
        is_prototype = not root.IsPseudoRoot()
        undefined = Usd.PrimIsActive & Usd.PrimIsLoaded & ~Usd.PrimIsAbstract
        predicate = undefined if is_prototype else Usd.PrimDefaultPredicate
        above = root.GetParent() if is_prototype else root
        transforms = UsdGeom.XformCache(self.time)
        parts: list[Part] = []
        prims = iter(Usd.PrimRange(root, Usd.TraverseInstanceProxies(predicate)))
        for prim in prims:
            if not prim.IsA(UsdGeom.Imageable):
                continue
            if not self._is_visible(prim, root):
                prims.PruneChildren()
                continue
            is_instancer = prim.IsA(UsdGeom.PointInstancer)
            if is_instancer:
                prims.PruneChildren()
            purpose = UsdGeom.Imageable(prim).ComputePurpose()
            if purpose not in (UsdGeom.Tokens.default_, UsdGeom.Tokens.render):
                continue
            if not is_instancer and not prim.IsA(UsdGeom.Gprim):
                continue
            found = (
                self._instances(UsdGeom.PointInstancer(prim)) if is_instancer else self._gprim(prim)
            )
            frame = prim
            if self.is_posed and prim.IsA(UsdGeom.Mesh):
                found, frame = self._skinned(prim, found)
            matrix, _ = transforms.ComputeRelativeTransform(frame, above)
            parts += [_moved(part, np.array(matrix, np.float64)) for part in found]
        return parts

    def _is_visible(self, prim: Any, root: Any) -> bool:
        """Of what is in a prototype nothing above it is asked."""
        from pxr import UsdGeom

        if root.IsPseudoRoot():
            return bool(
                UsdGeom.Imageable(prim).ComputeVisibility(self.time) != UsdGeom.Tokens.invisible
            )
        # Its ancestors were visible, or its children would have been skipped.
        return bool(
            UsdGeom.Imageable(prim).GetVisibilityAttr().Get(self.time) != UsdGeom.Tokens.invisible
        )

    def _gprim(self, prim: Any) -> list[Part]:
        from pxr import UsdGeom

        from .usd_shapes import faces_of

        # Its points and polygons.
        kind = str(prim.GetTypeName())
        gone: Int64 = np.zeros(0, np.int64)
        if prim.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(prim)
            points = _array(mesh.GetPointsAttr(), self.time, np.float64).reshape(-1, 3)
            counts = _array(mesh.GetFaceVertexCountsAttr(), self.time, np.int64)
            corners = _array(mesh.GetFaceVertexIndicesAttr(), self.time, np.int64)
            gone = _array(mesh.GetHoleIndicesAttr(), self.time, np.int64)
            scheme = mesh.GetSubdivisionSchemeAttr()
            if scheme.HasAuthoredValue() and scheme.Get() != UsdGeom.Tokens.none:
                self._leave_out(prim, "subdivision of Mesh")
        elif (shape := faces_of(self.path, prim, self.time)) is not None:
            points, counts, corners = shape
        else:
            self._leave_out(prim, kind)
            return []
        if (
            np.any(counts < 0)
            or len(corners) != sum(counts.tolist())
            or np.any((corners < 0) | (corners >= len(points)))
            or np.any((gone < 0) | (gone >= len(counts)))
        ):
            raise BuildError(f"{self.path}: the faces of {prim.GetPath()} do not fit its points")
        self._count(1, len(points), _triangles(counts))

        # Polygons that are holes go, and left-handed ones turn.
        part = Part(
            str(prim.GetPath()),
            prim,
            points,
            counts,
            corners,
            np.arange(len(counts)),
            np.arange(len(corners)),
        )
        if len(gone):
            part = _kept(part, ~np.isin(part.faces, gone))
        is_left_handed = (
            UsdGeom.Gprim(prim).GetOrientationAttr().Get(self.time) == UsdGeom.Tokens.leftHanded
        )
        # A closed form faces outward by itself.
        return [_turned(part) if is_left_handed and kind == "Mesh" else part]

    def _skinned(self, prim: Any, parts: list[Part]) -> tuple[list[Part], Any]:
        """The parts of a mesh where its skeleton moves them, and the prim in whose frame that
        is."""
        from pxr import Usd, UsdSkel, Vt

        skeleton = UsdSkel.BindingAPI(prim).GetInheritedSkeleton()
        root = UsdSkel.Root.Find(prim)
        if UsdSkel.BindingAPI(prim).GetBlendShapesAttr().HasAuthoredValue():
            self._leave_out(prim, "blend shapes of Mesh")
        if not skeleton or not root:
            return parts, prim
        if self.skeletons is None:
            self.skeletons = UsdSkel.Cache()
        cache = self.skeletons
        cache.Populate(root, Usd.TraverseInstanceProxies())
        skinning = cache.GetSkinningQuery(prim)
        transforms = cache.GetSkelQuery(skeleton).ComputeSkinningTransforms(self.time)
        points = [
            Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(part.points, np.float32)) for part in parts
        ]
        if not transforms or not all(
            skinning.ComputeSkinnedPoints(transforms, array, self.time) for array in points
        ):
            self._leave_out(prim, "skeleton of Mesh")
            return parts, prim
        moved = zip(parts, points, strict=True)
        return [
            replace(part, points=np.array(array, np.float64)) for part, array in moved
        ], skeleton.GetPrim()

    def _instances(self, instancer: Any) -> list[Part]:
        from pxr import UsdGeom

        # Where each instance is, from its prototype's own transform on, and which of them are
        # there.
        path = instancer.GetPath()
        prototypes = instancer.GetPrototypesRel().GetForwardedTargets()
        numbers = _array(instancer.GetProtoIndicesAttr(), self.time, np.int64)
        placed = instancer.ComputeInstanceTransformsAtTime(
            self.time,
            self.time,
            UsdGeom.PointInstancer.ExcludeProtoXform,
            UsdGeom.PointInstancer.IgnoreMask,
        )
        if len(placed) != len(numbers) or np.any((numbers < 0) | (numbers >= len(prototypes))):
            raise BuildError(
                f"{self.path}: the instances of {path} do not fit its prototypes and positions"
            )
        matrices = np.array(placed, np.float64).reshape(-1, 4, 4)
        there = np.array(instancer.ComputeMaskAtTime(self.time) or [True] * len(numbers), bool)

        # Each prototype is laid out.
        parts: list[Part] = []
        for number, prototype in enumerate(prototypes):
            chosen = np.flatnonzero((numbers == number) & there)
            for part in self._prototype(instancer, prototype) if len(chosen) else []:
                self._count(len(chosen), len(part.points), _triangles(part.counts))
                for instance in chosen.tolist():
                    moved = _moved(part, matrices[instance])
                    parts.append(replace(moved, name=f"{part.name}[{instance}]"))
        return parts

    def _prototype(self, instancer: Any, path: Any) -> list[Part]:
        """The parts of a prototype, read once."""
        known = str(path)
        if known not in self.prototypes:
            prim = instancer.GetPrim().GetStage().GetPrimAtPath(path)
            if not prim:
                self._leave_out(instancer.GetPrim(), "prototype that is not there")
            self.prototypes[known] = None
            self.prototypes[known] = self.gather(prim) if prim else []
        parts = self.prototypes[known]
        if parts is None:
            raise BuildError(f"{self.path}: {path} is an instance of itself")
        return parts

    def _count(self, parts: int, points: int, triangles: int) -> None:
        """Adds so many parts of so many points and triangles each."""
        self.parts += parts
        self.points += parts * points
        self.triangles += parts * triangles
        limits = {"meshes": (self.parts, MOST_PARTS), "points": (self.points, MOST_POINTS)}
        limits["triangles"] = (self.triangles, MOST_TRIANGLES)
        for what, (count, most) in limits.items():
            if count > most:
                raise BuildError(
                    f"{self.path}: has {count} {what} or more, each instance counted, must have "
                    f"at most {most}"
                )

    def _leave_out(self, prim: Any, what: str) -> None:
        first, count = self.left_out.get(what, (str(prim.GetPath()), 0))
        self.left_out[what] = (first, count + 1)

    def left_out_parts(self) -> list[str]:
        """A note of the prims left out, each kind once, if there are any."""
        listed = (
            f"{what} ({first}{f' and {count - 1} more' if count > 1 else ''})"
            for what, (first, count) in sorted(self.left_out.items())
        )
        return [f"left out: {', '.join(listed)}"] if self.left_out else []


def _missing(stage: Any) -> list[str]:
    """Files that the stage refers to and that are not there, if there are some."""
    missing = list(dict.fromkeys(str(error).strip() for error in stage.GetCompositionErrors()))
    if not missing:
        return []
    more = f" (and {len(missing) - 1} more)" if len(missing) > 1 else ""
    return [f"is not complete: {missing[0].splitlines()[0].rstrip('.')}{more}"]


def _triangles(counts: Int64) -> int:
    """How many triangles make polygons of so many corners."""
    return int(np.maximum(counts - 2, 0).sum())


def _array(attribute: Any, time: Any, dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    value = attribute.Get(time)
    return np.array([] if value is None else value, dtype)


def _moved(part: Part, matrix: Float64) -> Part:
    """A part under a transform; USD multiplies rows. A transform that mirrors turns the polygons
    round, too."""
    # The core refuses numbers that are not finite.
    with np.errstate(invalid="ignore", over="ignore"):
        points = part.points @ matrix[:3, :3] + matrix[3, :3]
        is_mirrored = bool(np.linalg.det(matrix[:3, :3]) < 0.0)
    moved = replace(part, points=points, linear=part.linear @ matrix[:3, :3])
    return _turned(moved) if is_mirrored else moved


def _turned(part: Part) -> Part:
    """The part with its corners in the opposite order."""
    ends = np.cumsum(part.counts)
    swap = np.repeat(2 * ends - part.counts - 1, part.counts) - np.arange(len(part.corners))
    return replace(part, corners=part.corners[swap], order=part.order[swap])


def _kept(part: Part, keep: npt.NDArray[np.bool_]) -> Part:
    """The part with some of its polygons."""
    corners = np.repeat(keep, part.counts)
    return replace(
        part,
        counts=part.counts[keep],
        corners=part.corners[corners],
        faces=part.faces[keep],
        order=part.order[corners],
    )


def _write_obj(path: str, parts: list[Part], time: Any) -> None:
    """All parts, with what their prims say besides."""
    from .usd_looks import said_of

    vertex = place = normal = 1
    with open(path, "w", encoding="utf-8") as file:
        for part in parts:
            said = said_of(part, time)
            points, corners = part.points, part.corners
            lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
            if said.colours is not None:
                # A vertex for each corner, as colours are the vertices'. Files of vertices have
                # them in sRGB.
                points, corners = points[corners], np.arange(len(corners))
                rows = np.concatenate([points, _srgb(said.colours)], axis=1).tolist()
                lines = [
                    f"v {x!r} {y!r} {z!r} {r:.9g} {g:.9g} {b:.9g}" for x, y, z, r, g, b in rows
                ]
            words = [(corners + vertex).astype(str)]
            if said.coordinates is not None:
                lines += [f"vt {u:.9g} {v:.9g}" for u, v in said.coordinates.tolist()]
                words.append((np.arange(len(corners)) + place).astype(str))
                place += len(corners)
            if said.normals is not None:
                lines += [f"vn {x:.9g} {y:.9g} {z:.9g}" for x, y, z in said.normals.tolist()]
                words += [np.full(len(corners), "")] if said.coordinates is None else []
                words.append((np.arange(len(corners)) + normal).astype(str))
                normal += len(corners)
            file.write(f"o {part.name}\n" + "\n".join(lines) + "\n")
            named = [
                "/".join(parts_of)
                for parts_of in zip(*(word.tolist() for word in words), strict=True)
            ]
            material = ""
            ends = np.cumsum(part.counts).tolist()
            for end, count, own in zip(ends, part.counts.tolist(), said.materials, strict=True):
                if own != material:
                    material = own
                    file.write(f"usemtl {own}\n")
                file.write(f"f {' '.join(named[end - count : end])}\n")
            file.write("usemtl\n")
            vertex += len(points)


def _srgb(linear: Float64) -> Float64:
    """Channels from 0 to 1 with sRGB's transfer function."""
    clipped = np.maximum(linear, 0.0)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1.0 / 2.4) - 0.055)
