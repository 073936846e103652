"""Collision groups, filtered pairs and joints of a stage, as groups of a scene's bodies: who passes
through whom."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pxr import Usd, UsdPhysics

from .usd_bodies import StageBody
from .usd_notes import Notes


def add_groups(
    stage: Any, bodies: list[StageBody], fields: list[dict[str, Any]], notes: Notes
) -> None:
    """Add ``groups`` and ``passes_through`` to the fields of bodies; groups have the paths of their
    prims for names, and the target of a filtered pair is a group of its own."""
    groups: list[list[str]] = [[] for _ in bodies]
    passes: list[list[str]] = [[] for _ in bodies]
    _add_collision_groups(stage, bodies, groups, passes, notes)
    _add_filtered_pairs(stage, bodies, groups, passes, notes)
    _add_joints(stage, bodies, groups, passes)
    # A group that nobody passes through has no effect, and neither has one that nobody is in.
    heard = {name for names in passes for name in names}
    filled = {name for names in groups for name in names}
    for one, own, through in zip(fields, groups, passes, strict=True):
        if kept := [name for name in dict.fromkeys(own) if name in heard]:
            one["groups"] = kept
        if passed := [name for name in dict.fromkeys(through) if name in filled]:
            one["passes_through"] = passed


def write_filtered_pairs(stage: Any, paths: list[str], bodies: list[dict[str, Any]]) -> None:
    """Say which of the bodies at these paths pass through which others, pair by pair: UsdPhysics
    has no body that passes through a group."""
    for path, body in zip(paths, bodies, strict=True):
        through = set(body.get("passes_through") or [])
        targets = [
            other
            for other, one in zip(paths, bodies, strict=True)
            if other != path and through.intersection(one.get("groups") or [])
        ]
        if targets:
            api = UsdPhysics.FilteredPairsAPI.Apply(stage.GetPrimAtPath(path))
            api.CreateFilteredPairsRel().SetTargets(targets)


def _add_collision_groups(
    stage: Any,
    bodies: list[StageBody],
    groups: list[list[str]],
    passes: list[list[str]],
    notes: Notes,
) -> None:
    prims = [prim for prim in _all_prims(stage) if prim.IsA(UsdPhysics.CollisionGroup)]
    if not prims:
        return
    labels = {prim.GetPath(): _label(prim) for prim in prims}
    passing = _passing(prims, labels, notes)
    queries = [
        UsdPhysics.CollisionGroup(prim).GetCollidersCollectionAPI().ComputeMembershipQuery()
        for prim in prims
    ]
    for index, body in enumerate(bodies):
        for prim, query in zip(prims, queries, strict=True):
            inside = [
                query.IsPathIncluded(collider.prim.GetPath())
                or query.IsPathIncluded(body.prim.GetPath())
                for collider in body.colliders
            ]
            if not any(inside):
                continue
            if not all(inside):
                notes.add("collision group of a part of a body", body.name, "is the whole body's")
            own = labels[prim.GetPath()]
            groups[index].append(own)
            passes[index] += [other for group, other in passing if group == own]


def _label(prim: Any) -> str:
    """Groups that are merged have one name."""
    merged = UsdPhysics.CollisionGroup(prim).GetMergeGroupNameAttr().Get()
    return str(merged or prim.GetPath())


def _passing(prims: list[Any], labels: dict[Any, str], notes: Notes) -> list[tuple[str, str]]:
    """Groups, and those that they pass through. The library's own table takes a target that is not
    there for its first group."""
    found: list[tuple[str, str]] = []
    for prim in prims:
        group = UsdPhysics.CollisionGroup(prim)
        targets = group.GetFilteredGroupsRel().GetForwardedTargets()
        if any(target not in labels for target in targets):
            notes.add("filtered group that is not there", prim.GetPath())
        through = {labels[target] for target in targets if target in labels}
        if group.GetInvertFilteredGroupsAttr().Get():
            through = set(labels.values()) - through
        found += [(labels[prim.GetPath()], other) for other in sorted(through)]
    return found


def _add_filtered_pairs(
    stage: Any,
    bodies: list[StageBody],
    groups: list[list[str]],
    passes: list[list[str]],
    notes: Notes,
) -> None:
    for prim in _all_prims(stage):
        if not prim.HasAPI(UsdPhysics.FilteredPairsAPI):
            continue
        targets = UsdPhysics.FilteredPairsAPI(prim).GetFilteredPairsRel().GetForwardedTargets()
        own = list(_bodies_at(prim.GetPath(), bodies))
        for target in targets:
            others = list(_bodies_at(target, bodies))
            if not own or not others:
                notes.add("filtered pair without two bodies", prim.GetPath())
                continue
            for index in others:
                groups[index].append(str(target))
            for index in own:
                passes[index].append(str(target))


def _add_joints(
    stage: Any, bodies: list[StageBody], groups: list[list[str]], passes: list[list[str]]
) -> None:
    """Two bodies of a joint do not collide, unless it says so: they overlap where they meet."""
    numbers: dict[Any, list[int]] = {}
    for index, body in enumerate(bodies):
        numbers.setdefault(body.prim.GetPath(), []).append(index)

    def of(relationship: Any) -> list[int]:
        targets = relationship.GetForwardedTargets()
        path = targets[0] if targets else None
        while path is not None and not path.isEmpty and path not in numbers:
            path = path.GetParentPath()
        return [] if path is None else numbers.get(path, [])

    for prim in _all_prims(stage):
        if not prim.IsA(UsdPhysics.Joint):
            continue
        joint = UsdPhysics.Joint(prim)
        if joint.GetCollisionEnabledAttr().Get() or not joint.GetJointEnabledAttr().Get():
            continue
        first, second = of(joint.GetBody0Rel()), of(joint.GetBody1Rel())
        if first and second and first != second:
            name = str(bodies[second[0]].prim.GetPath())
            for index in second:
                groups[index].append(name)
            for index in first:
                passes[index].append(name)


def _bodies_at(path: Any, bodies: list[StageBody]) -> Iterator[int]:
    """The bodies that a prim is, is a collider of, or has below it."""
    for index, body in enumerate(bodies):
        own = body.prim.GetPath()
        if own.HasPrefix(path) or any(one.prim.GetPath() == path for one in body.colliders):
            yield index


def _all_prims(stage: Any) -> Iterator[Any]:
    yield from stage.Traverse(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))
