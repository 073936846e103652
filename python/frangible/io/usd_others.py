"""What else of physics is in a stage: named, as a scene has no place for it."""

from __future__ import annotations

from typing import Any

from pxr import Usd, UsdGeom, UsdPhysics

from .usd_notes import Notes

#: Schemas of ours, and of UsdPhysics that are read.
_READ = {"PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "PhysicsMassAPI"}
_READ |= {"PhysicsMaterialAPI", "PhysicsFilteredPairsAPI", "FrangibleFractureAPI"}
#: Schemas of UsdPhysics that are not, what they are for, and what becomes of that.
_NAMED = {
    "PhysicsArticulationRootAPI": ("articulation", "its bodies move freely"),
}
#: Prefixes of schemas of engines.
_ENGINES = {"Physx": "PhysX", "Newton": "Newton", "Mjc": "MuJoCo", "Omni": "Omniverse"}


def name_others(stage: Any, colliding: set[Any], notes: Notes) -> None:
    """Joints, articulations, what is soft or does not collide, and settings of
    other engines. ``colliding`` are the paths of all colliders."""
    predicate = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
    for prim in stage.Traverse(predicate):
        path = prim.GetPath()
        if prim.IsA(UsdPhysics.Joint):
            joint = UsdPhysics.Joint(prim)
            if joint.GetJointEnabledAttr().Get():
                notes.add("joint", path, "its bodies move freely")
            # What drives and limits it goes with it.
            continue
        is_silent = path in colliding or prim.HasAPI(UsdPhysics.CollisionAPI)
        if prim.IsA(UsdGeom.Gprim) and not is_silent and _is_seen(prim):
            notes.add("shape that does not collide", path)
        if not prim.IsA(Usd.Typed) and prim.GetTypeName():
            notes.add(f"type {prim.GetTypeName()}, which USD does not know", path)
        elif prim.IsA(UsdGeom.TetMesh):
            notes.add("body that bends", path)
        for schema in prim.GetPrimTypeInfo().GetAppliedAPISchemas():
            name = schema.partition(":")[0]
            if name in _READ:
                continue
            if name in _NAMED:
                what, became = _NAMED[name]
                notes.add(what, path, became)
            else:
                engine = next(
                    (owner for prefix, owner in _ENGINES.items() if name.startswith(prefix)), None
                )
                if engine is not None:
                    notes.add(f"settings of {engine}", path)


def _is_seen(prim: Any) -> bool:
    image = UsdGeom.Imageable(prim)
    purposes = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)
    return bool(
        image.ComputePurpose() in purposes and image.ComputeVisibility() != UsdGeom.Tokens.invisible
    )
