"""The solid that a mesh encloses: the numbers that breaking it would begin with."""

from __future__ import annotations

from typing import Any

from .. import _frangible
from ..extras import missing_packages
from ..interrupts import deaf_work
from .break_mesh import DEFAULT_VOXELS
from .cleaning import CleanMesh


def describe_mesh(path: str) -> dict[str, object]:
    """Facts about a mesh file, in order; volume, centre and inertia are those of what `break_mesh`
    breaks."""
    return described(*read_facts(path))


def read_facts(path: str) -> tuple[dict[str, Any], CleanMesh | None]:
    """Facts about the triangles of a mesh file, for `described`, and its solids if they may have to
    be united."""
    facts = _frangible.mesh_info(path)
    clean = None
    if facts["volume_m3"] > 0.0 and missing_packages("exact") is None:
        clean = _frangible.clean_mesh(_frangible.load_mesh(path), path)
    return facts, clean


def described(facts: dict[str, Any], clean: CleanMesh | None) -> dict[str, object]:
    """The facts about a mesh with those about the solid that it encloses; its file is not needed
    any more."""
    notes: list[str] = facts.pop("notes")
    watertight: bool = facts["watertight"]
    if clean is not None and (clean["meets"].any() or clean["buried"].any()):
        from .exact_cut import arrays
        from .solids import closed

        with deaf_work():
            solid, notes = closed(clean, DEFAULT_VOXELS)
        facts.update(_frangible.mesh_mass(arrays(solid)))
    found: dict[str, object] = {}
    for key, value in facts.items():
        found[key] = value
        if key == "watertight":
            found["surface"] = "; ".join(
                ["closed" if watertight else "open or not consistent", *notes]
            )
    return found
