"""Materials in USD: UsdPreviewSurface, with images in a folder beside the file."""

from __future__ import annotations

from typing import Any

from pxr import Gf, Sdf, UsdShade

from ..materials import USD_WRAPS, Material
from .image_folder import ImageFolder


def add_material(stage: Any, path: str, side: Material, images: ImageFolder) -> Any:
    """A material prim at a path of the stage."""
    material = UsdShade.Material.Define(stage, path)
    if side.name and side.name != material.GetPrim().GetName():
        material.GetPrim().SetDisplayName(side.name)
    shader = UsdShade.Shader.Define(stage, f"{path}/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    # Numbers, then what images and the corners' colours put in their place.
    colours = {"diffuseColor": side.colour, "emissiveColor": side.emission}
    for name, colour in colours.items():
        if name == "diffuseColor" or any(colour):
            shader.CreateInput(name, Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*colour))
    numbers = {"roughness": side.roughness, "metallic": side.metallic, "opacity": 1.0 - side.clear}
    if side.cutoff is not None:
        numbers["opacityThreshold"] = side.cutoff
    for name, number in numbers.items():
        shader.CreateInput(name, Sdf.ValueTypeNames.Float).Set(number)
    if side.corner_colours:
        _connect(
            shader,
            "diffuseColor",
            _reader(stage, f"{path}/colours", "displayColor", "float3"),
            "result",
        )
    _add_images(stage, path, shader, side, images)
    material.CreateSurfaceOutput().ConnectToSource(
        shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    )
    return material


def _add_images(stage: Any, path: str, shader: Any, side: Material, images: ImageFolder) -> None:
    maps = {
        "image": (side.image, "sRGB", (*side.colour, 1.0 - side.clear), (0.0,) * 4),
        "surface_image": (
            side.surface_image,
            "raw",
            (1.0, side.roughness, side.metallic, 1.0),
            (0.0,) * 4,
        ),
        "normal_image": (side.normal_image, "raw", (2.0, 2.0, 2.0, 1.0), (-1.0, -1.0, -1.0, 0.0)),
        "emission_image": (side.emission_image, "sRGB", (*side.emission, 1.0), (0.0,) * 4),
    }
    inputs = {
        "image": [("diffuseColor", "rgb")]
        + ([("opacity", "a")] if side.blended or side.cutoff is not None else []),
        "surface_image": [("roughness", "g"), ("metallic", "b")],
        "normal_image": [("normal", "rgb")],
        "emission_image": [("emissiveColor", "rgb")],
    }
    places = None
    for name, (image, space, scale, bias) in maps.items():
        if image is None:
            continue
        places = places or _reader(stage, f"{path}/st", "st", "float2")
        texture = UsdShade.Shader.Define(stage, f"{path}/{name}")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(f"./{images.path(image)}")
        texture.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set(space)
        wraps = {"wrapS": image.sampler.wrap_s, "wrapT": image.sampler.wrap_t}
        for key, wrap in wraps.items():
            texture.CreateInput(key, Sdf.ValueTypeNames.Token).Set(USD_WRAPS[wrap])
        if scale != (1.0,) * 4:
            texture.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(*scale))
        if any(bias):
            texture.CreateInput("bias", Sdf.ValueTypeNames.Float4).Set(Gf.Vec4f(*bias))
        _connect(texture, "st", places, "result")
        for input_name, channel in inputs[name]:
            _connect(shader, input_name, texture, channel)


#: Types of a primvar reader's output, and of the inputs that are connected.
_TYPES = {
    "st": Sdf.ValueTypeNames.Float2,
    "diffuseColor": Sdf.ValueTypeNames.Color3f,
    "emissiveColor": Sdf.ValueTypeNames.Color3f,
    "normal": Sdf.ValueTypeNames.Normal3f,
    "float2": Sdf.ValueTypeNames.Float2,
    "float3": Sdf.ValueTypeNames.Float3,
    "rgb": Sdf.ValueTypeNames.Float3,
}


def _reader(stage: Any, path: str, primvar: str, kind: str) -> Any:
    reader = UsdShade.Shader.Define(stage, path)
    reader.CreateIdAttr(f"UsdPrimvarReader_{kind}")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set(primvar)
    reader.CreateOutput("result", _TYPES[kind])
    return reader


def _connect(shader: Any, name: str, source: Any, output: str) -> None:
    made = source.GetOutput(output) or source.CreateOutput(
        output, _TYPES.get(output, Sdf.ValueTypeNames.Float)
    )
    shader.CreateInput(name, _TYPES.get(name, Sdf.ValueTypeNames.Float)).ConnectToSource(made)
