"""`FrangibleFractureAPI`: how a body of a stage breaks, as fields of a scene's body."""

from __future__ import annotations

import os
from typing import Any

from pxr import Plug, Sdf

from ..material_presets import PRESETS
from .usd_stage import short_number
from .usd_strength import strength_points_of, write_strength_points

SCHEMA = "FrangibleFractureAPI"
#: Attributes begin with it.
SPACE = "frangible:"
#: The folder of the schema, which registers it.
FOLDER = os.path.join(os.path.dirname(os.path.dirname(__file__)), "usd_schema")

#: Attributes of a strength of its own, and their fields.
_STRENGTH = {
    "tensileStrength": "tensile_strength",
    "youngsModulus": "youngs_modulus",
    "fractureEnergy": "fracture_energy",
    "weibullModulus": "weibull_modulus",
}
#: Attributes of 'breaking' that have the names of its fields.
_BREAKING = ("pieces", "generations", "smallest", "reach", "twist", "point")

# Programs know the schema if this is read before the library looks for schemas; what it reads is
# the same without that.
Plug.Registry().RegisterPlugins(FOLDER)


def fracture_of(prim: Any) -> dict[str, Any]:
    """The fields that the schema gives a body: its material, how it breaks, its look. Empty for a
    prim without it."""
    if SCHEMA not in prim.GetPrimTypeInfo().GetAppliedAPISchemas():
        return {}
    said = _said(prim, "material")
    material = said or "concrete"
    if _said(prim, "breaks") is False:
        return {"material": {"like": material, "breaks": False}, **_look(prim)}
    breaking: dict[str, Any] = {}
    strength = _strength(prim)
    if strength is not None:
        breaking["strength"] = strength
    pattern = _pattern(prim)
    if (pulling := _said(prim, "glue:tensileStrength")) is not None:
        shearing = _said(prim, "glue:shearStrength")
        glue = {"tensile_strength": pulling, "shear_strength": shearing or pulling}
        own = pattern or PRESETS.get(material, {}).get("pattern")
        bonds = {**({} if own is None else {"pattern": own}), **glue, **_points(prim)}
        return {"material": material, **_look(prim), "bonds": bonds}
    if pattern is not None:
        breaking["pattern"] = pattern
    for name in _BREAKING:
        if (value := _said(prim, name)) not in (None, 0):
            breaking[name] = value
    breaking.update(_points(prim))
    # Nothing is left to a material where nobody named one and all is said.
    is_whole = not said and "strength" in breaking and "pattern" in breaking
    fields: dict[str, Any] = {} if is_whole else {"material": material}
    return {**fields, **_look(prim), **({"breaking": breaking} if breaking else {})}


def _points(prim: Any) -> dict[str, Any]:
    return strength_points_of(prim)


def voxels_of(prim: Any) -> int | None:
    """The voxels along the longest side of a mesh; `None` if the schema leaves them open."""
    return _said(prim, "voxels") or None


def _look(prim: Any) -> dict[str, Any]:
    return {"look": look} if (look := _said(prim, "look")) else {}


def _strength(prim: Any) -> Any:
    own = {field: _said(prim, name) for name, field in _STRENGTH.items()}
    own = {field: value for field, value in own.items() if value}
    return own or _said(prim, "strength") or _said(prim, "strengthOf") or None


def _pattern(prim: Any) -> dict[str, Any] | None:
    kind = _said(prim, "pattern")
    if not kind:
        return None
    pattern: dict[str, Any] = {"kind": kind}
    start = f"{SPACE}pattern:"
    for attribute in prim.GetPropertiesInNamespace(start.rstrip(":")):
        name = attribute.GetName().removeprefix(start)
        value = _said(prim, f"pattern:{name}")
        if value is not None and (name != "path" or kind == "file"):
            pattern[name] = value
    return pattern


def _said(prim: Any, name: str) -> Any:
    """The authored value of an attribute as plain data; `None` without one."""
    attribute = prim.GetAttribute(f"{SPACE}{name}")
    if not attribute or not attribute.HasAuthoredValue():
        return None
    value = attribute.Get()
    if isinstance(value, Sdf.AssetPath):
        return value.resolvedPath or value.path
    if isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, float):
        return (
            value if attribute.GetTypeName() == Sdf.ValueTypeNames.Double else short_number(value)
        )
    return [float(number) for number in value]


def write_fracture(prim: Any, body: dict[str, Any]) -> None:
    """Say with the schema how a body breaks, as far as it can; nothing for one that does not."""
    breaking = body.get("breaking")
    material = body.get("material")
    if not isinstance(breaking, dict) and not isinstance(material, str):
        return
    prim.AddAppliedSchema(SCHEMA)
    if isinstance(material, str):
        _write(prim, "material", material)
    if isinstance(body.get("look"), str):
        _write(prim, "look", body["look"])
    if not isinstance(breaking, dict):
        return
    strength = breaking.get("strength")
    if isinstance(strength, dict):
        for name, field in _STRENGTH.items():
            _write(prim, name, strength.get(field))
    else:
        _write(prim, "strengthOf" if isinstance(strength, str) else "strength", strength)
    for name in _BREAKING:
        _write(prim, name, breaking.get(name))
    write_strength_points(prim, breaking)
    pattern = breaking.get("pattern")
    if isinstance(pattern, dict):
        _write(prim, "pattern", pattern.get("kind"))
        for name, value in pattern.items():
            if name != "kind":
                _write(prim, f"pattern:{name}", value)


def _write(prim: Any, name: str, value: Any) -> None:
    types = Sdf.ValueTypeNames
    if value is None:
        return
    if isinstance(value, bool):
        kind = types.Bool
    elif isinstance(value, str):
        kind = types.Asset if name == "pattern:path" else types.Token
    elif name in _BREAKING[:2] or (isinstance(value, int) and abs(value) < 2**31):
        kind = types.Int if name not in ("strength", "smallest", *_STRENGTH) else types.Double
    elif isinstance(value, (int, float)):
        kind, value = types.Double, float(value)
    else:
        kind, value = types.Double3, tuple(float(number) for number in value)
    is_uniform = kind == types.Token
    attribute = prim.CreateAttribute(
        f"{SPACE}{name}",
        kind,
        False,
        Sdf.VariabilityUniform if is_uniform else Sdf.VariabilityVarying,
    )
    attribute.Set(Sdf.AssetPath(value) if kind == types.Asset else value)
