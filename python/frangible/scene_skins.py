"""Attributes of a scene's meshes, laid on bodies and fragments as they are recorded."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from . import _frangible
from .breaking.mesh_skin import MeshSkin, read_skin
from .breaking.volumes import volumes_differ
from .io.material_files import Known
from .io.mesh_files import readable_bodies
from .laid import Laid, Recorded
from .recording import Float32, Float64, rotation_matrix
from .scene_lines import FileScene
from .scene_looks import own_looks, scene_folder_file
from .scene_materials import with_materials
from .skin import Skin


@dataclass(frozen=True, slots=True)
class BodySkin:
    """Of a body that is a mesh, and of all its fragments."""

    mesh: MeshSkin
    #: [m] for each unit of the mesh's file.
    scale: float
    #: From the frame of the body's shape to the mesh's, for rows [m].
    rotation: Float64 = field(default_factory=lambda: np.eye(3))
    origin: Float64 = field(default_factory=lambda: np.zeros(3))

    def lay_on(self, surfaces: list[Recorded]) -> list[tuple[Skin, Float32]]:
        """The skins and the coordinates of the surfaces of bodies."""
        turns = [rotation_matrix(np.array(orientation)) for _, (_, orientation) in surfaces]
        in_mesh: list[Float64] = [
            (
                (surface[0].astype(np.float64) - np.array(origin)) @ turn @ self.rotation
                + self.origin
            )
            / self.scale
            for (surface, (origin, _)), turn in zip(surfaces, turns, strict=True)
        ]
        placed = [
            (vertices, surface[1], surface[2])
            for vertices, (surface, _) in zip(in_mesh, surfaces, strict=True)
        ]
        found = self.mesh.below(placed)
        laid = []
        for own, (surface, _), turn, below in zip(placed, surfaces, turns, found, strict=True):
            skin, coordinates = self.mesh.lay_on(*own, surface[3], below)
            if skin.normals is not None:
                turned = skin.normals @ (turn @ self.rotation).T
                skin = replace(skin, normals=turned.astype(np.float32))
            laid.append((skin, coordinates))
        return laid


def _meshes(scene: Any) -> Iterator[tuple[int, dict[str, Any], dict[str, Any]]]:
    """Number, description and shape of each body that is a mesh."""
    bodies = scene.get("bodies") if isinstance(scene, dict) else None
    for number, body in enumerate(bodies if isinstance(bodies, list) else []):
        shape = body.get("shape")
        if isinstance(shape, dict) and shape.get("kind") == "mesh":
            yield number, body, shape


def scene_skins(scene: Any, readable: Any, inside: str | None = None) -> dict[int, Laid]:
    """For the number of each body that has one, its skin. ``readable`` is what `readable_scene`
    made of the scene, in its context."""
    found: dict[int, Laid] = {}
    known: dict[str, MeshSkin | None] = {}
    materials: Known = {}
    for (number, _, shape), (_, _, plain) in zip(_meshes(scene), _meshes(readable), strict=True):
        path = str(shape["path"])
        if path not in known:
            # A folder of pieces has no materials of its own.
            known[path] = (
                None
                if os.path.isdir(path)
                else read_skin(path, str(plain["path"]), inside, materials)
            )
        skin = known[path]
        if skin is not None:
            found[number] = BodySkin(skin, float(shape.get("scale", 1.0)))
    if isinstance(scene, FileScene) and scene.skins:
        found.update(_prim_skins(scene, inside, materials))
    if isinstance(scene, dict):
        file = scene_folder_file(scene.name if isinstance(scene, FileScene) else "")
        for number, look in own_looks(with_materials(scene), file).items():
            found[number] = replace(look, mesh=found.get(number))
    return found


def _prim_skins(
    scene: FileScene, inside: str | None, known: Known
) -> Iterator[tuple[int, BodySkin]]:
    """Of bodies of a stage that are no meshes."""
    with readable_bodies(scene.name, (one.prim for one in scene.skins.values())) as files:
        for number, one in scene.skins.items():
            skin = read_skin(f"{scene.name}<{one.prim}>", files[one.prim], inside, known)
            if skin is not None:
                yield number, BodySkin(skin, 1.0, np.array(one.rotation), np.array(one.origin))


def volume_notes(readable: Any, masses: Any) -> list[str]:
    """Sentences about meshes whose bodies have another volume than they, given the masses of all
    bodies [kg]."""
    notes = []
    density = _frangible.scene_schema()["$defs"]["BodyDesc"]["properties"]["density"]["default"]
    for number, body, shape in _meshes(readable):
        mass = float(masses[number])
        if not np.isfinite(mass) or os.path.isdir(str(shape["path"])):
            continue
        scale = float(shape.get("scale", 1.0))
        raw = _frangible.load_mesh(str(shape["path"]))
        if (thickness := shape.get("thickness")) is not None:
            raw, _ = _frangible.thicken_mesh(raw, thickness / scale)
        clean = _frangible.clean_mesh(raw)
        if clean["meets"].any() or clean["buried"].any():
            continue
        mesh = (scale * clean["vertices"], clean["triangles"])
        longest = int(np.argmax(np.ptp(mesh[0], axis=0)))
        voxels = ((shape.get("resolution") or {}).get("voxels") or clean["voxels"])[longest]
        whole = _frangible.mesh_mass(mesh)["volume_m3"]
        on_grid = mass / float(body.get("density", density))
        how = "resolution.voxels of {} along the longest side"
        if sentence := volumes_differ(mesh, whole, on_grid, None, voxels, how):
            notes.append(f"bodies[{number}] ({body.get('name', '')}): {sentence}")
    return notes
