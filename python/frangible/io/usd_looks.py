"""Attributes of meshes in USD stages: material bindings, primvars, and UsdPreviewSurface."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Ar, UsdGeom, UsdShade

from ..materials import REPEAT, USD_WRAPS, Colour, Image, Material, Sampler
from .image_files import known_image
from .reading import FileNote, file_fault
from .usd_part import Part
from .usd_stage import open_stage

Rows = npt.NDArray[np.float64]

#: Primvars that hold texture coordinates, the first that is there.
_COORDINATES = ("st", "UVMap", "map1", "uv", "st0")
_GREY: Colour = (0.18, 0.18, 0.18)


@dataclass(frozen=True, slots=True)
class Said:
    """Of a part's corners (c, n) and its faces; `None` or empty where there is nothing."""

    coordinates: Rows | None
    #: Unit, in the frame of the points.
    normals: Rows | None
    #: Linear.
    colours: Rows | None
    #: The path of each face's material, empty for none.
    materials: list[str]


def said_of(part: Part, time: Any) -> Said:
    """Attributes of a part's prim, corner by corner in the part's order."""
    api = UsdGeom.PrimvarsAPI(part.prim)
    coordinates = next(
        (
            found
            for name in _COORDINATES
            if (found := _primvar(api, name, part, time, 2)) is not None
        ),
        None,
    )
    colours = _primvar(api, "displayColor", part, time, 3)
    normals = None
    if (
        part.prim.IsA(UsdGeom.Mesh)
        and UsdGeom.Mesh(part.prim).GetSubdivisionSchemeAttr().Get(time) == UsdGeom.Tokens.none
    ):
        normals = _normals(api, part, time)
    return Said(coordinates, normals, colours, _materials(part))


def _primvar(api: Any, name: str, part: Part, time: Any, columns: int) -> Rows | None:
    primvar = api.FindPrimvarWithInheritance(name)
    if not primvar or not primvar.HasValue():
        return None
    return _corners(primvar.ComputeFlattened(time), primvar.GetInterpolation(), part, columns)


def _normals(api: Any, part: Part, time: Any) -> Rows | None:
    found = _primvar(api, "normals", part, time, 3)
    if found is None:
        mesh = UsdGeom.Mesh(part.prim)
        found = _corners(mesh.GetNormalsAttr().Get(time), mesh.GetNormalsInterpolation(), part, 3)
    if found is None or abs(np.linalg.det(part.linear)) < 1e-30:
        return None
    turned: Rows = found @ np.linalg.inv(part.linear).T
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    return turned / np.where(lengths > 0.0, lengths, 1.0)


def _corners(value: Any, interpolation: str, part: Part, columns: int) -> Rows | None:
    """Values as they belong to the corners; `None` if there are not enough of them."""
    if value is None or len(value) == 0:
        return None
    rows = np.array(value, np.float64).reshape(len(value), -1)
    index = {
        UsdGeom.Tokens.constant: np.zeros(len(part.corners), np.int64),
        UsdGeom.Tokens.uniform: np.repeat(part.faces, part.counts),
        UsdGeom.Tokens.faceVarying: part.order,
    }.get(interpolation, part.corners)
    if (
        rows.shape[1] < columns
        or len(index) == 0
        or index.max() >= len(rows)
        or not np.all(np.isfinite(rows))
    ):
        return None
    found: Rows = rows[index, :columns]
    return found


def has_look(prim: Any) -> bool:
    """True if a prim has a material with a surface, or colours."""
    bound = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    if bound and bound.ComputeSurfaceSource()[0]:
        return True
    colours = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
    return bool(colours) and bool(colours.HasAuthoredValue())


def _materials(part: Part) -> list[str]:
    bound = UsdShade.MaterialBindingAPI(part.prim).ComputeBoundMaterial()[0]
    names = [str(bound.GetPath()) if bound else ""] * len(part.counts)
    if not part.prim.IsA(UsdGeom.Mesh):
        return names
    place = {face: index for index, face in enumerate(part.faces.tolist())}
    for subset in UsdShade.MaterialBindingAPI(part.prim).GetMaterialBindSubsets():
        own = UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()[0]
        for face in subset.GetIndicesAttr().Get() or () if own else ():
            if face in place:
                names[place[face]] = str(own.GetPath())
    return names


def stage_material_names(prim: Any) -> tuple[list[str], list[str]]:
    """Of each face of a mesh, the path of its material, empty for none, and the name of the subset
    that it is in."""
    bound = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    count = len(UsdGeom.Mesh(prim).GetFaceVertexCountsAttr().Get() or ())
    names, subsets = [str(bound.GetPath()) if bound else ""] * count, [""] * count
    for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
        own = UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()[0]
        for face in subset.GetIndicesAttr().Get() or ():
            if 0 <= face < count:
                subsets[face] = subset.GetPrim().GetName()
                names[face] = str(own.GetPath()) if own else names[face]
    return names, subsets


def read_usd_materials(path: str, names: list[str]) -> list[Material]:
    """The materials at paths of a stage."""
    with open_stage(path) as stage:
        return [
            _material(path, UsdShade.Material(stage.GetPrimAtPath(name)), name) for name in names
        ]


def _material(path: str, material: Any, at: str) -> Material:
    name = at.rpartition("/")[2]
    if not material:
        return Material(_GREY, 0.5, name=name)
    name = material.GetPrim().GetDisplayName() or name
    shader = material.ComputeSurfaceSource()[0]
    if not shader or shader.GetShaderId() != "UsdPreviewSurface":
        return Material(_GREY, 0.5, name=name)

    # Numbers and images.
    diffuse, scale = _texture(path, shader, "diffuseColor")
    glow, glow_scale = _texture(path, shader, "emissiveColor")
    rough, _ = _texture(path, shader, "roughness")
    metallic, _ = _texture(path, shader, "metallic")
    normal, _ = _texture(path, shader, "normal")
    opacity, _ = _texture(path, shader, "opacity")
    surface = rough or metallic
    cutoff = float(_value(shader, "opacityThreshold", 0.0))
    clear = (
        0.0
        if opacity is not None
        else 1.0 - min(max(float(_value(shader, "opacity", 1.0)), 0.0), 1.0)
    )
    return Material(
        _colour(_value(shader, "diffuseColor", _GREY)) if diffuse is None else scale,
        float(_value(shader, "roughness", 0.5)) if rough is None else 1.0,
        float(_value(shader, "metallic", 0.0)) if metallic is None else 1.0,
        clear=clear,
        name=name,
        emission=_colour(_value(shader, "emissiveColor", (0.0, 0.0, 0.0)))
        if glow is None
        else glow_scale,
        image=diffuse,
        surface_image=surface,
        normal_image=normal,
        emission_image=glow,
        cutoff=cutoff if cutoff > 0.0 else None,
        blended=opacity is not None and cutoff == 0.0,
        corner_colours=diffuse is None and _reads_colours(shader),
    )


def _source(shader: Any, name: str) -> Any:
    """The source of an input's value; `None` without the input."""
    found = shader.GetInput(name)
    attributes = found.GetValueProducingAttributes() if found else []
    return attributes[0] if attributes else None


def _value(shader: Any, name: str, otherwise: Any) -> Any:
    source = _source(shader, name)
    if source is None or UsdShade.Utils.GetType(source.GetName()) == UsdShade.AttributeType.Output:
        return otherwise
    value = source.Get()
    return otherwise if value is None else value


def _colour(value: Any) -> Colour:
    red, green, blue = (min(max(float(channel), 0.0), 1.0) for channel in value)
    return red, green, blue


def _reads_colours(shader: Any) -> bool:
    source = _source(shader, "diffuseColor")
    return source is not None and str(UsdShade.Shader(source.GetPrim()).GetShaderId()).startswith(
        "UsdPrimvarReader"
    )


def _texture(path: str, shader: Any, name: str) -> tuple[Image | None, Colour]:
    """The image of an input, and what it is multiplied with."""
    source = _source(shader, name)
    texture = UsdShade.Shader(source.GetPrim()) if source is not None else None
    if not texture or texture.GetShaderId() != "UsdUVTexture":
        return None, (1.0, 1.0, 1.0)
    asset = _value(texture, "file", None)
    if asset is None:
        return None, (1.0, 1.0, 1.0)
    image = _image(path, asset)
    if image is not None:
        # What the file leaves open, and what only USD has, repeats.
        wraps = {name: number for number, name in USD_WRAPS.items()}
        across, down = (
            wraps.get(str(_value(texture, key, "")), REPEAT) for key in ("wrapS", "wrapT")
        )
        image = replace(image, sampler=Sampler(across, down))
    return image, _colour(tuple(_value(texture, "scale", (1.0,) * 4))[:3])


def _image(path: str, asset: Any) -> Image | None:
    """An image in the stage's own folder or archive; a note and nothing if it is not there."""
    resolved = asset.resolvedPath
    outer = resolved.partition("[")[0] if resolved.endswith("]") else resolved
    folder = os.path.realpath(os.path.dirname(path) or ".")
    is_own = bool(resolved) and os.path.commonpath([folder, os.path.realpath(outer)]) == folder
    if not is_own or file_fault(outer):
        warnings.warn(
            f"{path}: has no image {asset.path!r} in its own folder", FileNote, stacklevel=2
        )
        return None
    if outer == resolved:
        with open(resolved, "rb") as file:
            data = file.read()
    else:
        opened = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(resolved))
        data = bytes(opened.GetBuffer()) if opened else b""
    return known_image(path, os.path.basename(resolved.rstrip("]")), data)
