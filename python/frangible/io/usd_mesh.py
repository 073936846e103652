"""Meshes and shapes of USD stages, written as an OBJ file that the core reads."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Usd, UsdGeom, UsdSkel, Vt

from .._frangible import MOST_TRIANGLES, BuildError
from ..recording import Int64
from .reading import FileNote
from .usd_obj import write_obj
from .usd_part import Part, kept, moved, turned
from .usd_shapes import faces_of
from .usd_stage import metres_from_stage, open_stage, time_code

#: The most points of a stage, its instances counted one by one: of triangles without neighbours.
MOST_POINTS = 3 * MOST_TRIANGLES
#: The most meshes, shapes and instances of them: some ten seconds.
MOST_PARTS = 200_000


def write_stage(path: str, obj: str, pose_time: float | None) -> None:
    """Write all meshes and shapes of a stage that are visible and no guides, as OBJ."""
    with open_stage(path) as stage:
        reader = StageReader(path, time_code(stage, pose_time), is_posed=pose_time is not None)
        units = np.eye(4)
        units[:3, :3] = metres_from_stage(path, stage).T
        parts = [moved(part, units) for part in reader.gather(stage.GetPseudoRoot())]
        notes = [*missing_files(stage), *reader.left_out_parts()]
        if not any(len(part.counts) for part in parts):
            raise BuildError("; ".join([f"{path}: has no mesh that can be seen", *notes]))
        write_obj(obj, parts, reader.time)
    for note in notes:
        warnings.warn(f"{path}: {note}", FileNote, stacklevel=2)


@dataclass(slots=True)
class StageReader:
    """Reads meshes and shapes, and counts them."""

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
                self._instances(UsdGeom.PointInstancer(prim))
                if is_instancer
                else self.parts_of(prim)
            )
            frame = prim
            if self.is_posed and prim.IsA(UsdGeom.Mesh):
                found, frame = self._skinned(prim, found)
            matrix, _ = transforms.ComputeRelativeTransform(frame, above)
            parts += [moved(part, np.array(matrix, np.float64)) for part in found]
        return parts

    def _is_visible(self, prim: Any, root: Any) -> bool:
        """Of what is in a prototype nothing above it is asked."""
        if root.IsPseudoRoot():
            return bool(
                UsdGeom.Imageable(prim).ComputeVisibility(self.time) != UsdGeom.Tokens.invisible
            )
        # Its ancestors were visible, or its children would have been skipped.
        return bool(
            UsdGeom.Imageable(prim).GetVisibilityAttr().Get(self.time) != UsdGeom.Tokens.invisible
        )

    def parts_of(self, prim: Any) -> list[Part]:
        """A mesh or shape by itself, in its own frame; nothing for any other prim."""

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
            part = kept(part, ~np.isin(part.faces, gone))
        is_left_handed = (
            UsdGeom.Gprim(prim).GetOrientationAttr().Get(self.time) == UsdGeom.Tokens.leftHanded
        )
        # A closed form faces outward by itself.
        return [turned(part) if is_left_handed and kind == "Mesh" else part]

    def _skinned(self, prim: Any, parts: list[Part]) -> tuple[list[Part], Any]:
        """The parts of a mesh where its skeleton moves them, and the prim in whose frame that
        is."""
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
        posed = [
            replace(part, points=np.array(array, np.float64))
            for part, array in zip(parts, points, strict=True)
        ]
        return posed, skeleton.GetPrim()

    def _instances(self, instancer: Any) -> list[Part]:

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
                    at_instance = moved(part, matrices[instance])
                    parts.append(replace(at_instance, name=f"{part.name}[{instance}]"))
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


def missing_files(stage: Any) -> list[str]:
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
