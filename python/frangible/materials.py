"""Materials, images and looks: linear RGB, picked so that a crack stands out at a glance."""

from __future__ import annotations

from dataclasses import dataclass

Colour = tuple[float, float, float]

#: Crack faces: fired clay.
INSIDE: Colour = (0.42, 0.15, 0.085)
INSIDE_ROUGHNESS = 0.9
#: The original surface, one colour for each source that can move.
OUTSIDE: tuple[Colour, ...] = (
    (0.54, 0.49, 0.41),  # limestone
    (0.13, 0.17, 0.23),  # gunmetal
    (0.28, 0.45, 0.52),  # verdigris
    (0.55, 0.42, 0.16),  # brass
    (0.42, 0.30, 0.42),  # heather
)
OUTSIDE_ROUGHNESS = 0.7
#: Whatever never moves.
SCENERY: Colour = (0.42, 0.43, 0.44)


#: How an image goes on beyond its edges, as glTF's numbers name it.
REPEAT, CLAMP, MIRROR = 10497, 33071, 33648
#: The same in USD.
USD_WRAPS = {REPEAT: "repeat", CLAMP: "clamp", MIRROR: "mirror"}
#: How an image is magnified, and made smaller, in glTF's numbers.
MAGNIFIED = (9728, 9729)
MINIFIED = (*MAGNIFIED, 9984, 9985, 9986, 9987)


@dataclass(frozen=True, slots=True)
class Sampler:
    """How an image is laid on; `None` for what the program that draws it decides."""

    #: Across, and down.
    wrap_s: int = REPEAT
    wrap_t: int = REPEAT
    magnified: int | None = None
    minified: int | None = None


@dataclass(frozen=True, slots=True)
class Image:
    """An image as its file holds it."""

    #: Of the file, with its ending.
    name: str
    #: "image/png" or "image/jpeg", as a rule.
    mime: str
    data: bytes
    sampler: Sampler = Sampler()


@dataclass(frozen=True, slots=True)
class Material:
    """One side of what a body is made of. Images are laid on by the texture coordinates; numbers
    multiply them."""

    colour: Colour
    roughness: float
    metallic: float = 0.0
    #: Share of the light that passes.
    clear: float = 0.0
    #: In the mesh's file, or as the user chose; empty for what a look is made of.
    name: str = ""
    #: Emitted light.
    emission: Colour = (0.0, 0.0, 0.0)
    #: sRGB; its alpha is the opacity.
    image: Image | None = None
    #: Green is roughness, blue is metallic, as in glTF.
    surface_image: Image | None = None
    #: Tangent space, y up, as in glTF.
    normal_image: Image | None = None
    #: sRGB.
    emission_image: Image | None = None
    #: Points of less opacity are not drawn; `None` where light passes by its share.
    cutoff: float | None = None
    #: True if the alpha of the image, or of the corners' colours, lets light through.
    blended: bool = False
    #: True if the colours of the corners are all that it shows.
    corner_colours: bool = False
    #: True if its back is drawn too.
    double_sided: bool = False

    def images(self) -> list[Image]:
        """All of its images."""
        every = (self.image, self.surface_image, self.normal_image, self.emission_image)
        return [image for image in every if image is not None]


@dataclass(frozen=True, slots=True)
class Look:
    """Appearance of a body."""

    #: Its original surface, and its crack faces.
    outside: Material
    inside: Material
    #: By how much pieces differ in brightness, relative to it.
    variation: float


#: Looks that a scene can give a body.
LOOKS: dict[str, Look] = {
    "glass": Look(
        Material((0.72, 0.95, 0.86), 0.02, clear=0.86),
        Material((0.28, 0.62, 0.47), 0.1, clear=0.45),
        0.0,
    ),
    "concrete": Look(Material((0.37, 0.365, 0.35), 0.85), Material((0.47, 0.44, 0.39), 0.95), 0.06),
    "brick": Look(Material((0.40, 0.115, 0.062), 0.85), Material((0.50, 0.175, 0.10), 0.95), 0.45),
    "mortar": Look(Material((0.56, 0.53, 0.47), 0.95), Material((0.58, 0.55, 0.49), 0.95), 0.10),
    "masonry": Look(Material((0.40, 0.115, 0.062), 0.85), Material((0.56, 0.53, 0.47), 0.95), 0.12),
    "wood": Look(Material((0.58, 0.37, 0.18), 0.65), Material((0.70, 0.47, 0.20), 0.85), 0.22),
    "stone": Look(Material((0.46, 0.43, 0.38), 0.85), Material((0.55, 0.52, 0.46), 0.95), 0.15),
    "metal": Look(
        Material((0.12, 0.12, 0.125), 0.35, metallic=1.0),
        Material((0.32, 0.32, 0.33), 0.5, metallic=1.0),
        0.1,
    ),
}
