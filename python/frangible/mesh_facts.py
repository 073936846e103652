"""The solid that a mesh encloses: the numbers that breaking it would begin with."""

from __future__ import annotations

from . import _frangible
from .breaking import DEFAULT_VOXELS
from .output import missing_packages


def describe_mesh(path: str) -> dict[str, object]:
    """Facts about a mesh file, in order; volume, centre and inertia are those of what `break_mesh` breaks."""
    facts = _frangible.mesh_info(path)
    notes: list[str] = facts.pop("notes")
    watertight: bool = facts["watertight"]
    if facts["volume_m3"] > 0.0 and missing_packages("exact") is None:
        clean = _frangible.clean_mesh(_frangible.load_mesh(path), path)
        if clean["meets"].any() or clean["buried"].any():
            from .boolean import arrays, closed

            solid, notes = closed(clean, DEFAULT_VOXELS)
            facts.update(_frangible.mesh_mass(arrays(solid)))
    described: dict[str, object] = {}
    for key, value in facts.items():
        described[key] = value
        if key == "watertight":
            described["surface"] = "; ".join(["closed" if watertight else "open or not consistent", *notes])
    return described
