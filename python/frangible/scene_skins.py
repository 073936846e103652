"""What the meshes of a scene look like: laid on bodies and fragments as they are recorded."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from . import _frangible
from .mesh_skin import MeshSkin, read_skin
from .recording import Bool, Float32, Float64, UInt32, rotation_matrix
from .skin import Skin
from .volumes import volumes_differ

#: Voxels along the longest side of a mesh that has no resolution of its own in a scene.
DEFAULT_VOXELS = 64
#: What a body of a scene weighs that does not say it [kg/m^3].
DEFAULT_DENSITY = 2400.0


@dataclass(frozen=True, slots=True)
class BodySkin:
    """Of a body that is a mesh, and of all its fragments."""

    mesh: MeshSkin
    #: [m] for each unit of the mesh's file.
    scale: float

    def lay_on(
        self,
        surface: tuple[Float32, UInt32, Bool, Float32],
        material_frame: tuple[list[float], list[float]],
    ) -> tuple[Skin, Float32]:
        """The skin and the coordinates of a body's surface, given the frame of its material in the body frame."""
        vertices, triangles, interior, coordinates = surface
        origin, orientation = material_frame
        turn = rotation_matrix(np.array(orientation))
        in_mesh: Float64 = (vertices.astype(np.float64) - np.array(origin)) @ turn / self.scale
        skin, placed = self.mesh.lay_on(in_mesh, triangles, interior, coordinates)
        if skin.normals is None:
            return skin, placed
        return replace(skin, normals=(skin.normals @ turn.T).astype(np.float32)), placed


def _meshes(scene: Any) -> Iterator[tuple[int, dict[str, Any], dict[str, Any]]]:
    """Number, description and shape of each body that is a mesh."""
    bodies = scene.get("bodies") if isinstance(scene, dict) else None
    for number, body in enumerate(bodies if isinstance(bodies, list) else []):
        shape = body.get("shape")
        if isinstance(shape, dict) and shape.get("kind") == "mesh":
            yield number, body, shape


def scene_skins(scene: Any, readable: Any, inside: str | None = None) -> dict[int, BodySkin]:
    """For the number of each body that has one, its skin. ``readable`` is what `readable_scene` made of the scene, in its context."""
    found: dict[int, BodySkin] = {}
    known: dict[str, MeshSkin | None] = {}
    for (number, _, shape), (_, _, plain) in zip(_meshes(scene), _meshes(readable), strict=True):
        path = str(shape["path"])
        if path not in known:
            known[path] = read_skin(path, str(plain["path"]), inside)
        skin = known[path]
        if skin is not None:
            found[number] = BodySkin(skin, float(shape.get("scale", 1.0)))
    return found


def volume_notes(readable: Any, masses: Any) -> list[str]:
    """Sentences about meshes whose bodies have another volume than they, given the masses of all bodies [kg]."""
    notes = []
    for number, body, shape in _meshes(readable):
        mass = float(masses[number])
        if not np.isfinite(mass):
            continue
        clean = _frangible.clean_mesh(_frangible.load_mesh(str(shape["path"])))
        if clean["meets"].any() or clean["buried"].any():
            continue
        scale = float(shape.get("scale", 1.0))
        mesh = (scale * clean["vertices"], clean["triangles"])
        longest = int(np.argmax(np.ptp(mesh[0], axis=0)))
        voxels = ((shape.get("resolution") or {}).get("voxels") or [DEFAULT_VOXELS] * 3)[longest]
        whole = _frangible.mesh_mass(mesh)["volume_m3"]
        on_grid = mass / float(body.get("density", DEFAULT_DENSITY))
        how = "resolution.voxels of {} along the longest side"
        if sentence := volumes_differ(mesh, whole, on_grid, None, voxels, how):
            notes.append(f"bodies[{number}] ({body.get('name', '')}): {sentence}")
    return notes
