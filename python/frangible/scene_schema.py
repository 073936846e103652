"""The JSON Schema of scenes: the core's, and the materials that Python resolves for it."""

from __future__ import annotations

from typing import Any

from . import _frangible
from .material_presets import PRESETS

#: What a body is made of: every field that a material decides, and how the material is made.
_MATERIAL: dict[str, Any] = {
    "type": "object",
    "additionalProperties": False,
    "properties": {
        "like": {
            "type": ["string", "null"],
            "description": "A preset, or another material of the scene, that the rest comes from.",
        },
        "density": {"type": ["number", "null"], "description": "[kg/m^3]"},
        "friction": {"type": ["number", "null"], "description": "Coulomb's coefficient."},
        "rolling_friction": {"type": ["number", "null"], "description": "As of a body [m]."},
        "spinning_friction": {"type": ["number", "null"], "description": "As of a body [m]."},
        "restitution": {"type": ["number", "null"], "description": "In [0, 1]."},
        "strength": {
            "anyOf": [{"$ref": "#/$defs/StrengthDesc"}, {"type": "null"}],
            "description": "Strength of bodies that break.",
        },
        "pattern": {
            "anyOf": [{"$ref": "#/$defs/PatternDesc"}, {"type": "null"}],
            "description": "Pattern of bodies that break.",
        },
        "look": {
            "anyOf": [
                {"$ref": "#/$defs/LookDesc"},
                {"$ref": "#/$defs/OwnLook"},
                {"type": "null"},
            ],
            "description": "Appearance.",
        },
        "breaks": {
            "type": ["boolean", "null"],
            "description": "Whether dynamic bodies break that say nothing of 'breaking' and have "
            "no bonds; without it, they do if there are a strength and a pattern.",
        },
    },
    "description": "Everything that a material decides about a body. A field of the body itself "
    "counts more.",
}


_SHARE = {"type": ["number", "null"]}
_IMAGE = {"type": ["string", "null"]}
_COLOUR = {
    "type": ["array", "null"],
    "items": {"type": "number"},
    "minItems": 3,
    "maxItems": 3,
}
#: One side of a look.
_SURFACE: dict[str, Any] = {
    "type": "object",
    "additionalProperties": False,
    "properties": {
        "name": {"type": ["string", "null"], "description": "In files; without it the body's."},
        "colour": {
            **_COLOUR,
            "description": "Linear red, green, blue, from 0 to 1; multiplied with the image's.",
        },
        "emission": {**_COLOUR, "description": "Emitted light, likewise."},
        "roughness": {**_SHARE, "description": "From 0 to 1; without it 0.8."},
        "metallic": {**_SHARE, "description": "From 0 to 1; without it 0."},
        "opacity": {**_SHARE, "description": "From 0 to 1; without it 1."},
        "image": {
            **_IMAGE,
            "description": "PNG or JPEG with the colours, in the scene's folder or below.",
        },
        "normal_image": {**_IMAGE, "description": "With normals, as in glTF."},
        "surface_image": {
            **_IMAGE,
            "description": "Green is roughness, blue is metallic, as in glTF.",
        },
        "emission_image": {**_IMAGE, "description": "With emitted light."},
    },
    "description": "One side of a body in pictures and files.",
}
_OWN_LOOK: dict[str, Any] = {
    "type": "object",
    "additionalProperties": False,
    "properties": {
        "outside": {"$ref": "#/$defs/Surface", "description": "The original surface."},
        "inside": {
            "anyOf": [{"$ref": "#/$defs/Surface"}, {"type": "null"}],
            "description": "What cracks lay bare; without it as the outside.",
        },
        "tile": {
            "type": ["number", "null"],
            "description": "Side of the square that images cover, on bodies without texture "
            "coordinates of a file [m]; without it 1.",
        },
    },
    "required": ["outside"],
    "description": "A look of one's own.",
}


def scene_schema() -> dict[str, Any]:
    """The JSON Schema of scenes, as a dictionary."""
    schema: dict[str, Any] = _frangible.scene_schema()
    names = ", ".join(PRESETS)
    schema["properties"]["materials"] = {
        "type": "object",
        "additionalProperties": {"$ref": "#/$defs/Material"},
        "description": "Materials of one's own, by name.",
    }
    schema["$defs"]["BodyDesc"]["properties"]["material"] = {
        "anyOf": [{"type": "string"}, {"$ref": "#/$defs/Material"}, {"type": "null"}],
        "description": "Decides density, friction, restitution, strength, pattern and look, as "
        f"far as the body does not: a preset ({names}), one of the scene's, or one given here.",
    }
    look = schema["$defs"]["BodyDesc"]["properties"]["look"]
    look["anyOf"].insert(1, {"$ref": "#/$defs/OwnLook"})
    schema["$defs"] |= {"Surface": _SURFACE, "OwnLook": _OWN_LOOK}
    # The material has them, too.
    breaking = schema["$defs"]["BreakingDesc"]
    for field in breaking.pop("required"):
        text = f"{breaking['properties'][field]['description']} Needed, if the material has none."
        breaking["properties"][field]["description"] = text
    schema["$defs"]["Material"] = _MATERIAL
    return schema
