"""Looks of a scene's own: colours and textures of bodies, outside and on cracks."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ._frangible import BuildError
from .io.image_files import image_file
from .laid import Laid, Recorded
from .materials import Colour, Image, Material
from .recording import Float32
from .skin import Skin
from .words import did_you_mean, shown

#: Fields of a side that are shares from 0 to 1, and what they are without being said.
_SHARES = {"roughness": 0.8, "metallic": 0.0, "opacity": 1.0}
#: Fields of a side that are images.
_IMAGES = ("image", "normal_image", "surface_image", "emission_image")
_COLOURS = ("colour", "emission")
SIDE = ("name", *_COLOURS, *_SHARES, *_IMAGES)
#: Fields of a look.
FIELDS = ("outside", "inside", "tile")


@dataclass(frozen=True, slots=True)
class OwnLook:
    """Of a body and all its fragments."""

    outside: Material
    inside: Material
    #: Side of the square that an image covers, where the body has no texture coordinates of a file
    #: [m].
    tile: float
    #: Of the body's mesh, whose coordinates and normals it keeps.
    mesh: Laid | None = None

    def lay_on(self, surfaces: list[Recorded]) -> list[tuple[Skin, Float32]]:
        """The skins and the texture coordinates of the surfaces."""
        laid = []
        below = None if self.mesh is None else self.mesh.lay_on(surfaces)
        for number, ((_, triangles, interior, own), _) in enumerate(surfaces):
            material = np.where(interior, 1, 0).astype(np.int32)
            skin = Skin((self.outside, self.inside), material)
            coordinates: Float32 = (own / self.tile).astype(np.float32)
            if below is not None:
                found, placed = below[number]
                skin = replace(skin, normals=found.normals, path=found.path)
                # What the file does not place is in metres.
                is_own = (placed == own).all(axis=(1, 2), keepdims=True)
                coordinates = np.where(is_own, coordinates, placed).astype(np.float32)
            assert len(material) == len(triangles)
            laid.append((skin, coordinates))
        return laid


def without_own_looks(scene: dict[str, Any]) -> dict[str, Any]:
    """The scene as the core reads it: it knows looks by their names only."""
    bodies = scene.get("bodies")
    if not isinstance(bodies, list) or not any(_own(body) is not None for body in bodies):
        return scene
    plain = [
        {field: value for field, value in body.items() if field != "look"}
        if _own(body) is not None
        else body
        for body in bodies
    ]
    return {**scene, "bodies": plain}


def _own(body: Any) -> dict[str, Any] | None:
    look = body.get("look") if isinstance(body, dict) else None
    return look if isinstance(look, dict) else None


def own_looks(scene: dict[str, Any], file: str) -> dict[int, OwnLook]:
    """The looks of a scene's own, by the numbers of bodies; images are in the folder of the scene's
    file. `BuildError` with path, value and rule for one that cannot be."""
    bodies = scene.get("bodies")
    found: dict[int, OwnLook] = {}
    known: dict[str, Image | None] = {}
    for number, body in enumerate(bodies if isinstance(bodies, list) else []):
        look = _own(body)
        if look is None:
            continue
        path = f"bodies[{number}].look"
        whose = f' (body "{name}")' if (name := body.get("name")) else ""
        try:
            found[number] = _look(look, path, str(name or "own"), file, known)
        except BuildError as error:
            raise BuildError(f"{error}{whose}") from None
    return found


def _look(
    look: dict[str, Any], path: str, name: str, file: str, known: dict[str, Image | None]
) -> OwnLook:
    _check_fields(look, FIELDS, path)
    if look.get("outside") is None:
        raise BuildError(f"{path}.outside: missing, must be an object with a colour or an image")
    tile = _number(look.get("tile", 1.0), f"{path}.tile", math.inf)
    if not tile > 0.0:
        raise BuildError(f"{path}.tile: {shown(tile)}, must be > 0")
    sides = []
    for side in ("outside", "inside"):
        said = look.get(side) or look["outside"]
        sides.append(_side(said, f"{path}.{side}", f"{name}_{side}", file, known))
    return OwnLook(sides[0], sides[1], tile)


def _side(side: Any, path: str, name: str, file: str, known: dict[str, Image | None]) -> Material:
    if not isinstance(side, dict):
        raise BuildError(f"{path}: {shown(side)}, must be an object")
    _check_fields(side, SIDE, path)
    shares = {
        field: _number(side.get(field, otherwise), f"{path}.{field}", 1.0)
        for field, otherwise in _SHARES.items()
    }
    images: dict[str, Image | None] = {}
    for field in _IMAGES:
        said = side.get(field)
        if said is None:
            continue
        if not isinstance(said, str):
            raise BuildError(f"{path}.{field}: {shown(said)}, must be the path of an image")
        if said not in known:
            known[said] = image_file(file, said)
        images[field] = known[said]
    white = images.get("image") is not None
    emission = (1.0, 1.0, 1.0) if images.get("emission_image") is not None else (0.0, 0.0, 0.0)
    return Material(
        colour=_colour(side.get("colour"), f"{path}.colour", (1.0,) * 3 if white else (0.5,) * 3),
        roughness=shares["roughness"],
        metallic=shares["metallic"],
        clear=1.0 - shares["opacity"],
        emission=_colour(side.get("emission"), f"{path}.emission", emission),
        name=str(side.get("name") or name),
        image=images.get("image"),
        normal_image=images.get("normal_image"),
        surface_image=images.get("surface_image"),
        emission_image=images.get("emission_image"),
    )


def _check_fields(fields: dict[str, Any], known: tuple[str, ...], path: str) -> None:
    for field in fields:
        if field not in known:
            rule = f"must be one of {', '.join(known)}"
            raise BuildError(f"{path}.{field}: unknown field{did_you_mean(field, known)}, {rule}")


def _number(value: Any, path: str, most: float) -> float:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not is_number or not 0.0 <= value <= most or not math.isfinite(value):
        rule = "a number from 0 to 1" if most == 1.0 else "a number > 0"
        raise BuildError(f"{path}: {shown(value)}, must be {rule}")
    return float(value)


def _colour(value: Any, path: str, otherwise: tuple[float, ...]) -> Colour:
    if value is None:
        red, green, blue = otherwise
        return red, green, blue
    if not isinstance(value, (list, tuple)) or len(value) != 3:
        raise BuildError(f"{path}: {shown(value)}, must be a list of 3 numbers from 0 to 1")
    red, green, blue = (
        _number(channel, f"{path}[{index}]", 1.0) for index, channel in enumerate(value)
    )
    return red, green, blue


def scene_folder_file(name: str) -> str:
    """A file in whose folder the images of a scene are: its own, or one in the current folder."""
    return name or os.path.join(os.curdir, "scene")
