"""Materials of a scene, resolved into the fields of its bodies: the core knows no materials."""

from __future__ import annotations

import copy
import json
from typing import Any

from ._frangible import BuildError
from .material_presets import PRESETS
from .words import did_you_mean, shown

#: Fields of a material that are fields of a body.
_OF_BODY = ("density", "friction", "rolling_friction", "spinning_friction", "restitution", "look")
#: Fields of a material that are fields of 'breaking'.
_OF_BREAKING = ("strength", "pattern")
FIELDS = ("like", *_OF_BODY, *_OF_BREAKING, "breaks")


def has_materials(scene: Any) -> bool:
    """True if something in the scene is left to `with_materials`."""
    if not isinstance(scene, dict):
        return False
    bodies = scene.get("bodies")
    return "materials" in scene or (
        isinstance(bodies, list)
        and any(isinstance(body, dict) and "material" in body for body in bodies)
    )


def scene_materials_text(scene: dict[str, Any]) -> str:
    """The materials of the scene's own as JSON; empty without any."""
    own = scene.get("materials")
    return json.dumps(own) if own else ""


def with_materials(scene: dict[str, Any]) -> dict[str, Any]:
    """The scene with each body's fields as its material decides them, where the body does not.

    `BuildError` with path, value and rule for a material that there is not.
    """
    resolved = copy.deepcopy(scene)
    own = resolved.pop("materials", None)
    own = {} if own is None else own
    if not isinstance(own, dict):
        raise BuildError(f"materials: {shown(own)}, must be an object with a material by name")
    for name in own:
        _material(name, own, f"materials.{name}", ())
    bodies = resolved.get("bodies")
    for number, body in enumerate(bodies if isinstance(bodies, list) else []):
        if not isinstance(body, dict) or (said := body.pop("material", None)) is None:
            continue
        whose = f' (body "{name}")' if (name := body.get("name")) else ""
        try:
            material = _material(said, own, f"bodies[{number}].material", ())
        except BuildError as error:
            raise BuildError(f"{error}{whose}") from None
        _give(body, material)
    return resolved


def _give(body: dict[str, Any], material: dict[str, Any]) -> None:
    """A material's fields to a body that has none of its own."""
    for field in _OF_BODY:
        if body.get(field) is None and material.get(field) is not None:
            body[field] = copy.deepcopy(material[field])
    breaking = {
        field: copy.deepcopy(material[field])
        for field in _OF_BREAKING
        if material.get(field) is not None
    }
    if isinstance(body.get("breaking"), dict):
        said = {field: value for field, value in body["breaking"].items() if value is not None}
        body["breaking"] = {**breaking, **said}
        return
    may_break = body.get("motion", "dynamic") == "dynamic" and body.get("bonds") is None
    breaks = material.get("breaks")
    if body.get("breaking") is None and may_break and breaks is not False:
        if len(breaking) == len(_OF_BREAKING) or breaks:
            body["breaking"] = breaking


def _material(said: Any, own: dict[str, Any], path: str, above: tuple[str, ...]) -> dict[str, Any]:
    """All fields of a material that is named or given; ``above`` are those that are like it."""
    if isinstance(said, str):
        if said in above:
            raise BuildError(f"{path}: {shown(said)}, must not be like itself")
        if said in own:
            return _material(own[said], own, f"materials.{said}", (*above, said))
        if said in PRESETS:
            return PRESETS[said]
        known = [*own, *PRESETS]
        rule = f"must be one of {', '.join(known)}"
        raise BuildError(f"{path}: {shown(said)}{did_you_mean(said, known)}, {rule}")
    if not isinstance(said, dict):
        raise BuildError(f"{path}: {shown(said)}, must be the name of a material, or an object")
    for field in said:
        if field not in FIELDS:
            rule = f"must be one of {', '.join(FIELDS)}"
            raise BuildError(f"{path}.{field}: unknown field{did_you_mean(field, FIELDS)}, {rule}")
    breaks = said.get("breaks")
    if breaks is not None and not isinstance(breaks, bool):
        raise BuildError(f"{path}.breaks: {shown(breaks)}, must be true or false")
    like = said.get("like")
    # A scene's own concrete may be like the preset of that name.
    is_preset = like in PRESETS and above[-1:] == (like,)
    base = (
        {}
        if like is None
        else PRESETS[like]
        if is_preset
        else _material(like, own, f"{path}.like", above)
    )
    return {**base, **{field: value for field, value in said.items() if value is not None}}
