"""The rigid bodies of a UsdPhysics stage, and the colliders of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics

from .._frangible import BuildError
from ..recording import Float64
from .usd_notes import Notes

#: The most bodies of a stage, its instances counted one by one.
MOST_BODIES = 100_000


@dataclass(frozen=True, slots=True)
class Collider:
    """A shape that collides."""

    prim: Any
    #: (4, 4) from the prim's frame to the world's, metres, y up; rows.
    world: Float64


@dataclass(slots=True)
class StageBody:
    """A body with its colliders; a collider that is no body's is a static one by itself."""

    prim: Any
    #: The prim's path; of an instance of an instancer with its number behind it.
    name: str
    world: Float64
    motion: Literal["dynamic", "kinematic", "static"]
    colliders: list[Collider] = field(default_factory=list)
    #: True if a prim of an instancer is placed as many bodies.
    is_instanced: bool = False


def find_bodies(stage: Any, units: Float64, time: Any, notes: Notes) -> list[StageBody]:
    """All bodies, in the order of the stage. ``units`` (4, 4) turns its lengths into metres, y
    up."""
    finder = _Finder(stage, units, time, notes)
    finder.gather(stage.GetPseudoRoot(), np.eye(4), "")
    return finder.bodies


class _Finder:
    def __init__(self, stage: Any, units: Float64, time: Any, notes: Notes) -> None:
        self.stage, self.units, self.time, self.notes = stage, units, time, notes
        self.transforms = UsdGeom.XformCache(time)
        self.bodies: list[StageBody] = []

    def gather(self, root: Any, placed: Float64, instance: str) -> None:
        """The bodies at and below a prim; ``placed`` moves them, and ``instance`` is added to their
        names."""
        is_prototype = not root.IsPseudoRoot()
        undefined = Usd.PrimIsActive & Usd.PrimIsLoaded & ~Usd.PrimIsAbstract
        predicate = undefined if is_prototype else Usd.PrimDefaultPredicate
        #: The bodies above the prim, innermost last; `None` where transforms begin anew.
        above: list[tuple[Any, StageBody]] = []
        #: Prims that are no shapes and whose shapes collide, all that are below them.
        whole: list[Any] = []
        prims = iter(Usd.PrimRange(root, Usd.TraverseInstanceProxies(predicate)))
        for prim in prims:
            path = prim.GetPath()
            while above and not path.HasPrefix(above[-1][0]):
                above.pop()
            if prim.IsA(UsdGeom.PointInstancer):
                prims.PruneChildren()
                self._instances(UsdGeom.PointInstancer(prim), placed)
                continue
            if self._is_reset(prim):
                above.clear()
            world = self._world(prim) @ placed @ self.units
            body = above[-1][1] if above else None
            is_body = prim.HasAPI(UsdPhysics.RigidBodyAPI)
            says_so = prim.HasAPI(UsdPhysics.CollisionAPI)
            collides = says_so or (
                prim.IsA(UsdGeom.Gprim) and any(path.HasPrefix(one) for one in whole)
            )
            if (is_body or collides) and not np.isfinite(world).all():
                file = self.stage.GetRootLayer().identifier
                raise BuildError(f"{file}: the transform of {path} has a number that is not finite")
            if is_body:
                body = self._body(prim, world, body, f"{path}{instance}")
                if body is not None and not (above and above[-1][1] is body):
                    above.append((path, body))
            if says_so:
                if self._collider(prim, world, body, f"{path}{instance}"):
                    whole.append(path)
            elif collides:
                self._add_collider(prim, world, body, f"{path}{instance}")

    def _world(self, prim: Any) -> Float64:
        """From the prim's frame to the stage's."""
        return np.array(self.transforms.GetLocalToWorldTransform(prim), np.float64)

    def _is_reset(self, prim: Any) -> bool:
        return prim.IsA(UsdGeom.Xformable) and bool(UsdGeom.Xformable(prim).GetResetXformStack())

    def _body(
        self, prim: Any, world: Float64, above: StageBody | None, name: str
    ) -> StageBody | None:
        """The body of a prim; the one above it if that takes it in, `None` if it is switched
        off."""
        api = UsdPhysics.RigidBodyAPI(prim)
        if above is not None:
            self.notes.add("rigid body in a rigid body", prim.GetPath(), "a part of the outer one")
            return above
        if not api.GetRigidBodyEnabledAttr().Get(self.time):
            return None
        kinematic = bool(api.GetKinematicEnabledAttr().Get(self.time))
        body = StageBody(prim, name, world, "kinematic" if kinematic else "dynamic")
        self._add(body)
        return body

    def _collider(self, prim: Any, world: Float64, body: StageBody | None, name: str) -> bool:
        """Add a collider; true if it is no shape, and no prim below it is said to collide: all
        shapes there do."""
        if not UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Get(self.time):
            return False
        if not prim.IsA(UsdGeom.Gprim):
            children = list(Usd.PrimRange(prim, Usd.TraverseInstanceProxies()))[1:]
            if any(child.HasAPI(UsdPhysics.CollisionAPI) for child in children):
                return False
            if not any(child.IsA(UsdGeom.Gprim) for child in children):
                self.notes.add("collider that is no shape", prim.GetPath())
                return False
            return True
        self._add_collider(prim, world, body, name)
        return False

    def _add_collider(self, prim: Any, world: Float64, body: StageBody | None, name: str) -> None:
        if body is None:
            body = StageBody(prim, name, world, "static")
            self._add(body)
        body.colliders.append(Collider(prim, world))

    def _add(self, body: StageBody) -> None:
        if len(self.bodies) >= MOST_BODIES:
            self.notes.add(f"more than {MOST_BODIES} bodies", body.name)
            # What collides with it is gathered, and goes with it.
            return
        self.bodies.append(body)

    def _instances(self, instancer: Any, placed: Float64) -> None:
        """The bodies of each instance of an instancer."""
        prototypes = list(_prototypes(self.stage, instancer))
        if not any(_has_physics(prim) for prim in prototypes if prim):
            return
        numbers = instancer.GetProtoIndicesAttr().Get(self.time) or []
        matrices = instancer.ComputeInstanceTransformsAtTime(
            self.time,
            self.time,
            UsdGeom.PointInstancer.ExcludeProtoXform,
            UsdGeom.PointInstancer.IgnoreMask,
        )
        mask = instancer.ComputeMaskAtTime(self.time) or [True] * len(numbers)
        own = self._world(instancer.GetPrim())
        first = len(self.bodies)
        for number, (prototype, matrix, there) in enumerate(
            zip(numbers, matrices, mask, strict=False)
        ):
            if not there or not 0 <= prototype < len(prototypes) or not prototypes[prototype]:
                continue
            prim = prototypes[prototype]
            # From the stage's frame to that of the prototype's parent, then to the instance.
            parent = self._world(prim.GetParent()) if prim.GetParent() else np.eye(4)
            moved = np.linalg.inv(parent) @ np.array(matrix, np.float64) @ own @ placed
            self.gather(prim, moved, f"[{number}]")
        for body in self.bodies[first:]:
            body.is_instanced = True


def _prototypes(stage: Any, instancer: Any) -> Iterator[Any]:
    for path in instancer.GetPrototypesRel().GetForwardedTargets():
        yield stage.GetPrimAtPath(path)


def _has_physics(prim: Any) -> bool:
    undefined = Usd.PrimIsActive & Usd.PrimIsLoaded & ~Usd.PrimIsAbstract
    return any(
        one.HasAPI(UsdPhysics.RigidBodyAPI) or one.HasAPI(UsdPhysics.CollisionAPI)
        for one in Usd.PrimRange(prim, Usd.TraverseInstanceProxies(undefined))
    )
