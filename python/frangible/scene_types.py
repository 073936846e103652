"""The objects of scenes as dataclasses, with the fields and words of the JSON Schema.

Made by `frangible schema --python`; a test compares it with the schema.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from os import PathLike
from typing import Any, ClassVar, Literal

import numpy.typing as npt

from .description import Description

#: A list of numbers, such as a vector, or an array.
Numbers = Sequence[float] | npt.NDArray[Any]
#: A list of lists of numbers, such as points, or an array.
Rows = Sequence[Sequence[float]] | npt.NDArray[Any]

#: Method that advances a frame.
Method = Literal["frame-rate", "paper", "paper-uncorrected"]

#: Minimum number of substeps; islands that bear, press or turn more take more.
Quality = Literal["draft", "game", "default", "film"]

#: Sides of a mesh's triangles that are solid: a static or kinematic mesh is its triangles, closed
#: or open. Without a choice, "one" for a mesh that encloses a volume and faces outward, else "two".
Sides = Literal["one", "two"]

#: The cause of a body's motion.
Motion = Literal["dynamic", "kinematic", "static"]

#: An event that a body waits for.
StartsWhen = Literal["struck"]

#: Materials of the table, without densities.
StrengthName = Literal["glass", "concrete", "brick", "wood", "ice"]

#: The look of a body.
Look = Literal["glass", "concrete", "brick", "mortar", "masonry", "wood", "stone", "metal"]


@dataclass(slots=True)
class Solver(Description):
    """Contact solver of the frame-rate method."""

    _: KW_ONLY
    #: Minimum number of substeps of bodies in contact. Without it 'default'.
    quality: Quality | None = None
    #: Maximum number of substeps of an island of bodies, a power of two from the quality's minimum
    #: to 1024. Loads and impacts beyond overlap further. Without it 128.
    most_substeps: int | None = None
    #: Maximum speed of penetration recovery, above 0 [m/s]. Without it 3.0.
    recovery_speed: float | None = None


@dataclass(slots=True)
class Resolution(Description):
    """Sampling resolution of a shape."""

    _: KW_ONLY
    #: Level-set voxels across the bounding box along x, y, z; voxels are cubes, hence the largest
    #: need decides. Without it, closed forms stay formulas, hulls stay polyhedra, and shapes that
    #: need samples get 64 voxels along their longest side, or three across their thinnest part, if
    #: that is finer and makes no more voxels than a cube has.
    voxels: Numbers | None = None
    #: Distance between surface samples [m]. Without it, two voxels, or a tenth of the longest side
    #: for shapes without a grid.
    sample_spacing: float | None = None


@dataclass(slots=True)
class BoxPart(Description):
    """A box."""

    KIND: ClassVar[str | None] = "box"

    #: Edge lengths [m].
    size: Numbers

    _: KW_ONLY
    #: Of its middle [m]. Without it [0.0, 0.0, 0.0].
    position: Numbers | None = None
    #: Quaternion x, y, z, w that takes the part's frame to the compound's; need not be of unit
    #: length. Without it [0.0, 0.0, 0.0, 1.0].
    orientation: Numbers | None = None


@dataclass(slots=True)
class HullPart(Description):
    """The convex hull of points."""

    KIND: ClassVar[str | None] = "hull"

    #: At least four [m].
    points: Rows

    _: KW_ONLY
    #: Of the points' origin [m]. Without it [0.0, 0.0, 0.0].
    position: Numbers | None = None
    #: Quaternion x, y, z, w that takes the points' frame to the compound's; need not be of unit
    #: length. Without it [0.0, 0.0, 0.0, 1.0].
    orientation: Numbers | None = None


#: A part of a compound, in the compound's frame.
Part = BoxPart | HullPart


@dataclass(slots=True)
class HalfSpace(Description):
    """All below the plane y = 0; static only."""

    KIND: ClassVar[str | None] = "half-space"


@dataclass(slots=True)
class Sphere(Description):
    """A ball."""

    KIND: ClassVar[str | None] = "sphere"

    #: [m]
    radius: float

    _: KW_ONLY
    #: Needed if it breaks.
    resolution: Resolution | None = None


@dataclass(slots=True)
class Box(Description):
    """A box."""

    KIND: ClassVar[str | None] = "box"

    #: Edge lengths [m].
    size: Numbers

    _: KW_ONLY
    #: Needed if it breaks.
    resolution: Resolution | None = None


@dataclass(slots=True)
class Cylinder(Description):
    """Around the y axis."""

    KIND: ClassVar[str | None] = "cylinder"

    #: [m]
    radius: float
    #: [m]
    height: float

    _: KW_ONLY
    #: Needed if it breaks.
    resolution: Resolution | None = None


@dataclass(slots=True)
class Capsule(Description):
    """All within a radius of a segment of the y axis."""

    KIND: ClassVar[str | None] = "capsule"

    #: [m]
    radius: float
    #: Of the segment, without the round ends [m].
    height: float

    _: KW_ONLY
    #: Needed if it breaks.
    resolution: Resolution | None = None


@dataclass(slots=True)
class Cone(Description):
    """Around the y axis, its apex up; its base lies a quarter of its height below its centre of
    mass, the origin."""

    KIND: ClassVar[str | None] = "cone"

    #: Of the base [m].
    radius: float
    #: [m]
    height: float

    _: KW_ONLY
    #: Needed if it breaks.
    resolution: Resolution | None = None


@dataclass(slots=True)
class Hull(Description):
    """The convex hull of points."""

    KIND: ClassVar[str | None] = "hull"

    #: At least four [m]; points inside the hull of the others have no effect.
    points: Rows

    _: KW_ONLY
    #: Needed if it breaks.
    resolution: Resolution | None = None


@dataclass(slots=True)
class Compound(Description):
    """A compound of boxes and convex hulls: a convex decomposition. Parts may touch; the mass of
    overlaps counts twice."""

    KIND: ClassVar[str | None] = "compound"

    #: At least one.
    parts: list[Part]

    _: KW_ONLY
    #: Needed if it breaks.
    resolution: Resolution | None = None


@dataclass(slots=True)
class Mesh(Description):
    """A mesh file: OBJ, PLY, STL or glTF."""

    KIND: ClassVar[str | None] = "mesh"

    #: Path.
    path: str | PathLike[str]

    _: KW_ONLY
    #: The file's unit in metres. Without it 1.0.
    scale: float | None = None
    #: Thickness of plates made from open parts [m]; without it open parts are left out where a mesh
    #: is sampled.
    thickness: float | None = None
    #: Solid sides of the triangles of a static or kinematic body.
    sides: Sides | None = None
    #: A mesh that moves or breaks is always sampled; that of a static or kinematic body is if this
    #: is given.
    resolution: Resolution | None = None


@dataclass(slots=True)
class Triangles(Description):
    """A mesh that is given here."""

    KIND: ClassVar[str | None] = "triangles"

    #: Vertices [m].
    positions: Rows
    #: Three vertices each, counted from 0, counter-clockwise seen from outside.
    triangles: Rows

    _: KW_ONLY
    #: Thickness of plates made from open parts [m]; without it open parts are left out where a mesh
    #: is sampled.
    thickness: float | None = None
    #: Solid sides of the triangles of a static or kinematic body.
    sides: Sides | None = None
    #: A mesh that moves or breaks is always sampled; that of a static or kinematic body is if this
    #: is given.
    resolution: Resolution | None = None


@dataclass(slots=True)
class Heightfield(Description):
    """Ground from rows of heights: row k, column i stands at x = i, z = k times the spacing, the
    middle of the field above the origin. Static or kinematic only."""

    KIND: ClassVar[str | None] = "heightfield"

    #: At least two rows of equal lengths of at least two [m].
    heights: Rows
    #: Between columns along x and between rows along z [m].
    spacing: Numbers

    _: KW_ONLY
    #: Solid sides; without it one: solid below.
    sides: Sides | None = None


#: A shape in its own frame.
Shape = (
    HalfSpace
    | Sphere
    | Box
    | Cylinder
    | Capsule
    | Cone
    | Hull
    | Compound
    | Mesh
    | Triangles
    | Heightfield
)


@dataclass(slots=True)
class Keyframe(Description):
    """Pose of a body at a frame."""

    #: 0 is the start; may lie between whole frames.
    frame: float
    #: As that of the body [m].
    position: Numbers

    _: KW_ONLY
    #: As that of the body. Without it [0.0, 0.0, 0.0, 1.0].
    orientation: Numbers | None = None


@dataclass(slots=True)
class Starts(Description):
    """When a body begins to move: at a frame, or when it is struck; one of the two. Until then it
    holds still and is to others a body of infinite mass that does not break."""

    _: KW_ONLY
    #: At this frame it is still where it was, and moves from there, with its initial velocities.
    frame: int | None = None
    #: In the frame-rate method.
    when: StartsWhen | None = None


@dataclass(slots=True)
class Mass(Description):
    """Mass, centre of mass and inertia of a body that is not filled evenly: hollow, loaded, or
    stood in for by a simple shape. What is left out follows from the shape and the density."""

    _: KW_ONLY
    #: Instead of the density's [kg].
    mass: float | None = None
    #: In the shape's frame [m], at most ten times its length outside; of a round shape its own, the
    #: middle.
    center: Numbers | None = None
    #: Principal moments of inertia about the centre of mass, each > 0 and at most the sum of the
    #: other two [kg m^2]. Without them, those of the shape about that centre.
    moments: Numbers | None = None
    #: Quaternion x, y, z, w that takes the axes of the moments to the shape's frame; need not be of
    #: unit length. One of a cylinder's, a capsule's and a cone's lies along its y axis. Without it
    #: [0.0, 0.0, 0.0, 1.0].
    axes: Numbers | None = None


@dataclass(slots=True)
class Strength(Description):
    """Fracture properties of a material. The energy of a blow limits its number of pieces: cracks
    take their energy from the bodies' relative motion."""

    #: Tensile strength of the whole body; fragments are stronger [Pa].
    tensile_strength: float
    #: Young's modulus; with the density it gives the speed of sound [Pa].
    youngs_modulus: float
    #: Fracture energy per crack area [J/m^2].
    fracture_energy: float

    _: KW_ONLY
    #: Weibull modulus m, the uniformity of flaws: strength grows as the power -1/m of the volume
    #: [Wei51]. Without it 10.0.
    weibull_modulus: float | None = None


#: The strength of a body: an impulse, or its material's.
AnyStrength = float | StrengthName | Strength


@dataclass(slots=True)
class Radial(Description):
    """Wedges around the line of impact, and rings, as glass breaks."""

    KIND: ClassVar[str | None] = "radial"

    _: KW_ONLY
    #: Number of wedges around the centre, at least 3; the paper's pattern has 12. Without it 12.
    spokes: int | None = None
    #: Number of rings around the centre, denser towards it; 0 is the paper's pattern. Without it 0.
    rings: int | None = None
    #: Irregularity, from 0 (regular) to 1. Without it 0.5.
    jitter: float | None = None
    #: Of the random numbers. Without it 1.
    seed: int | None = None


@dataclass(slots=True)
class Voronoi(Description):
    """Voronoi cells."""

    KIND: ClassVar[str | None] = "voronoi"

    _: KW_ONLY
    #: Number of cells, from 1 to 10000. Without it 25.
    cells: int | None = None
    #: From 0 to 30. 0 spreads the points evenly over the box; any other number gathers them around
    #: the centre, in a Gaussian whose standard deviation is `half_extent / clustering`. Without it
    #: 0.0.
    clustering: float | None = None
    #: From -10 to 10 along each axis. The points are `exp(2 grading)` times as dense at the box's
    #: upper end of an axis as at its lower, growing exponentially: small pieces at one end, large
    #: ones at the other. Without it [0.0, 0.0, 0.0].
    grading: Numbers | None = None
    #: Of the random numbers. Without it 1.
    seed: int | None = None
    #: Shape of the pattern's box; only its proportions matter. A flat one suits walls that are
    #: struck on their face. Without it [1.0, 1.0, 1.0].
    half_extent: Numbers | None = None


@dataclass(slots=True)
class Natural(Description):
    """Rubble, as rock breaks."""

    KIND: ClassVar[str | None] = "natural"

    _: KW_ONLY
    #: Number of cells, from 1 to 10000. Without it 25.
    cells: int | None = None
    #: Spread of sizes, from 0 (the largest cell cracks) over 0.5 (probability proportional to
    #: volume) to 1 (equal probability). Without it 0.7.
    spread: float | None = None
    #: Gathers small cells around the centre, from 0 (everywhere alike) to 30: a cell cracks the
    #: more likely the nearer it is, by a Gaussian whose standard deviation is `half_extent /
    #: clustering`. Without it 0.0.
    clustering: float | None = None
    #: Of the random numbers. Without it 1.
    seed: int | None = None
    #: Shape of the pattern's box; only its proportions matter. Without it [1.0, 1.0, 1.0].
    half_extent: Numbers | None = None


@dataclass(slots=True)
class Slices(Description):
    """Slices across an axis."""

    KIND: ClassVar[str | None] = "slices"

    _: KW_ONLY
    #: Number of slices, from 1 to 10000. Without it 8.
    cells: int | None = None
    #: Normal of the slices; any length except zero. z is the collision normal, x the longest
    #: direction across it. Without it [1.0, 0.0, 0.0].
    axis: Numbers | None = None
    #: Irregularity, from 0 (equally thick, parallel) to 1 (neighbours nearly touch at an edge of
    #: the box). Without it 0.3.
    jitter: float | None = None
    #: Of the random numbers. Without it 1.
    seed: int | None = None
    #: Shape of the pattern's box; only its proportions matter. Without it [1.0, 1.0, 1.0].
    half_extent: Numbers | None = None


@dataclass(slots=True)
class Bricks(Description):
    """Bricks and mortar."""

    KIND: ClassVar[str | None] = "bricks"

    _: KW_ONLY
    #: Number of bricks along a course, joints included; at least 1. Without it 6.
    columns: int | None = None
    #: Number of courses, joints included; at least 1. Without it 18.
    courses: int | None = None
    #: Thickness of the joints relative to the height of a course, from 0 (none) to 0.5. Without it
    #: 0.14.
    mortar: float | None = None
    #: Irregularity from 0 to 1: displacement of the bricks' ends. Without it 0.1.
    jitter: float | None = None
    #: Of the random numbers. Without it 1.
    seed: int | None = None
    #: Shape of the pattern's box; only its proportions matter. Without it [1.0, 1.0, 0.25].
    half_extent: Numbers | None = None


@dataclass(slots=True)
class Splinters(Description):
    """Splinters along a grain, as wood breaks."""

    KIND: ClassVar[str | None] = "splinters"

    _: KW_ONLY
    #: Number of splinters side by side, from 1 to 10000 with their pieces. Without it 24.
    fibres: int | None = None
    #: Number of pieces that each splinter is broken into along its length, at least 1. Without it
    #: 2.
    pieces: int | None = None
    #: Along what the splinters lie: 0, 1 or 2 for the pattern's x, y or z. x follows the body's
    #: longest side. Without it 0.
    grain: int | None = None
    #: Length of the pointed ends relative to the splinter's width, from 0 (cut square) to 20.
    #: Without it 4.0.
    sharpness: float | None = None
    #: Displacement of the splinters' breaks from their regular places, from 0 (all in the same
    #: place) to 1, in piece lengths. Without it 0.5.
    spread: float | None = None
    #: Of the random numbers. Without it 1.
    seed: int | None = None
    #: Shape of the pattern's box; only its proportions matter. A long one suits what is long along
    #: the grain. Without it [1.0, 0.25, 0.25].
    half_extent: Numbers | None = None


@dataclass(slots=True)
class Concrete(Description):
    """Voronoi cells with rough faces."""

    KIND: ClassVar[str | None] = "concrete"

    _: KW_ONLY
    #: Number of cells, from 1 to 10000. Without it 25.
    cells: int | None = None
    #: Roughness of the faces, from 0 (planar) to 1 (the limit for connected cells). Without it 0.7.
    roughness: float | None = None
    #: Size of the largest bumps, relative to that of a cell; from 0.05 to 2. Without it 0.7.
    grain: float | None = None
    #: As of `Voronoi`. Without it 0.0.
    clustering: float | None = None
    #: Of the random numbers. Without it 1.
    seed: int | None = None
    #: Shape of the pattern's box; only its proportions matter. Without it [1.0, 1.0, 1.0].
    half_extent: Numbers | None = None


@dataclass(slots=True)
class PatternFile(Description):
    """A saved or drawn pattern."""

    KIND: ClassVar[str | None] = "file"

    #: Input of `Pattern::load`(frangible_fracture::Pattern::load): a saved pattern, or a mesh file,
    #: in which each closed part is a cell.
    path: str | PathLike[str]


#: Pattern of prescored space [Su09 sec. 4.3]: a generator with its parameters, each of which has a
#: default, or a file.
AnyPattern = Radial | Voronoi | Natural | Slices | Bricks | Splinters | Concrete | PatternFile


@dataclass(slots=True)
class StrengthPoint(Description):
    """Strength of a body at a point."""

    #: In the shape's own frame [m].
    point: Numbers
    #: Times the strength of the body, from 1e-6 to 1e6.
    factor: float


@dataclass(slots=True)
class Breaking(Description):
    """Fracture of a body."""

    _: KW_ONLY
    #: Strength of the body. Needed, if the material has none.
    strength: AnyStrength | None = None
    #: Pattern of prescored space. Needed, if the material has none.
    pattern: AnyPattern | None = None
    #: Approximate number of pieces per break, from 2 to 10000: the pattern's number of cells is
    #: chosen for the impact point; a pattern from a file is magnified. By default the pattern is
    #: used as described.
    pieces: int | None = None
    #: Number of consecutive breaks: 1 means that fragments do not break. Without it 1.
    generations: int | None = None
    #: Minimum longest side of fragments that break again [m]. Without it 0.0.
    smallest: float | None = None
    #: How far a break reaches from its blow [m]: the rest stays whole, and is broken as before by
    #: the next blow. The pattern is laid on what is in reach; bricks, slices and files are laid on
    #: the whole body, and of them the cells with their centres in reach come loose. By default all
    #: of the body breaks.
    reach: float | None = None
    #: Point of the shape at the pattern's centre, in the shape's own frame [m]; by default the
    #: blow's. What breaks again breaks where it is struck.
    point: Numbers | None = None
    #: Turn of the pattern about the blow's direction [rad].
    twist: float | None = None
    #: Points at which the body is stronger or weaker; beside them strength is a mean of the eight
    #: nearest, the nearer the more. Not with the paper's method.
    strength_points: list[StrengthPoint] | None = None
    #: Triangles between these points, by their numbers from 0 on, as those of a painted mesh:
    #: strength is then that of the nearest triangle, linear between its corners.
    strength_triangles: Rows | None = None


@dataclass(slots=True)
class Anchor(Description):
    """A fixing box along the world's axes."""

    #: Lowest corner [m].
    low: Numbers
    #: Highest corner [m].
    high: Numbers


@dataclass(slots=True)
class Bonds(Description):
    """A body of glued pieces: a bond at each common face of two pieces. It moves as one body until
    bonds break."""

    #: Tensile strength of a bond, in pulling and bending [Pa].
    tensile_strength: float
    #: Shear strength of a bond, in shearing and twisting [Pa].
    shear_strength: float

    _: KW_ONLY
    #: Pattern that cuts the body into pieces. Without it, the parts of a compound are the pieces,
    #: or the closed parts of a mesh, as `frangible break` writes them: a file or a folder of OBJ
    #: files.
    pattern: AnyPattern | None = None
    #: Point of the shape at the pattern's centre, in the shape's own frame [m]; by default the
    #: middle of the shape.
    point: Numbers | None = None
    #: Direction of the pattern's normal, in the shape's frame; need not be of unit length. Without
    #: it [0.0, 1.0, 0.0].
    normal: Numbers | None = None
    #: Pieces with their centre in one of these boxes are fixed to the world. Without any, the body
    #: moves freely.
    anchors: list[Anchor] | None = None
    #: Points at which bonds are stronger or weaker, as those of `breaking`.
    strength_points: list[StrengthPoint] | None = None
    #: Triangles between these points, as those of `breaking`.
    strength_triangles: Rows | None = None


@dataclass(slots=True)
class Surface(Description):
    """One side of a body in pictures and files."""

    _: KW_ONLY
    #: In files; without it the body's.
    name: str | None = None
    #: Linear red, green, blue, from 0 to 1; multiplied with the image's.
    colour: Numbers | None = None
    #: Emitted light, likewise.
    emission: Numbers | None = None
    #: From 0 to 1; without it 0.8.
    roughness: float | None = None
    #: From 0 to 1; without it 0.
    metallic: float | None = None
    #: From 0 to 1; without it 1.
    opacity: float | None = None
    #: PNG or JPEG with the colours, in the scene's folder or below.
    image: str | None = None
    #: With normals, as in glTF.
    normal_image: str | None = None
    #: Green is roughness, blue is metallic, as in glTF.
    surface_image: str | None = None
    #: With emitted light.
    emission_image: str | None = None


@dataclass(slots=True)
class OwnLook(Description):
    """A look of one's own."""

    #: The original surface.
    outside: Surface

    _: KW_ONLY
    #: What cracks lay bare; without it as the outside.
    inside: Surface | None = None
    #: Side of the square that images cover, on bodies without texture coordinates of a file [m];
    #: without it 1.
    tile: float | None = None


@dataclass(slots=True)
class Material(Description):
    """Everything that a material decides about a body. A field of the body itself counts more."""

    _: KW_ONLY
    #: A preset, or another material of the scene, that the rest comes from.
    like: str | None = None
    #: [kg/m^3]
    density: float | None = None
    #: Coulomb's coefficient.
    friction: float | None = None
    #: As of a body [m].
    rolling_friction: float | None = None
    #: As of a body [m].
    spinning_friction: float | None = None
    #: In [0, 1].
    restitution: float | None = None
    #: Strength of bodies that break.
    strength: AnyStrength | None = None
    #: Pattern of bodies that break.
    pattern: AnyPattern | None = None
    #: Appearance.
    look: Look | OwnLook | None = None
    #: Whether dynamic bodies break that say nothing of 'breaking' and have no bonds; without it,
    #: they do if there are a strength and a pattern.
    breaks: bool | None = None


@dataclass(slots=True)
class Body(Description):
    """One body."""

    #: Shape of the body.
    shape: Shape

    _: KW_ONLY
    #: For people; need not be unique.
    name: str | None = None
    #: The cause of its motion. Without it 'dynamic'.
    motion: Motion | None = None
    #: Of the origin of the shape's own frame (a mesh's or points' coordinates, the centre of a
    #: closed form) [m]. Without it [0.0, 0.0, 0.0].
    position: Numbers | None = None
    #: Quaternion x, y, z, w that takes the shape's frame to the world's; need not be of unit
    #: length. Without it [0.0, 0.0, 0.0, 1.0].
    orientation: Numbers | None = None
    #: Of the centre of mass, up to 1e5 along each axis [m/s]. Without it [0.0, 0.0, 0.0].
    linear_velocity: Numbers | None = None
    #: Up to 1e4 about each axis [rad/s]. Without it [0.0, 0.0, 0.0].
    angular_velocity: Numbers | None = None
    #: Poses of a kinematic body at frames, in ascending order: it is there exactly at the end of
    #: each frame. In between its centre of mass moves straight and it turns evenly; before the
    #: first and after the last it stands still. Instead of `position`, `orientation` and
    #: velocities.
    path: list[Keyframe] | None = None
    #: When a dynamic body begins to move; without it, at once.
    starts: Starts | None = None
    #: From 1e-6 to 1e9 [kg/m^3]. Without it 2400.0.
    density: float | None = None
    #: Of a body that is not filled evenly; a dynamic one that neither breaks nor is glued.
    mass_properties: Mass | None = None
    #: Names of the groups that it is in, for `passes_through` of others; its pieces are too.
    groups: list[str] | None = None
    #: Groups whose bodies it does not collide with, nor they with it; its pieces do not either.
    passes_through: list[str] | None = None
    #: Coulomb's coefficient; a pair has the smaller of its two. Without it 0.5.
    friction: float | None = None
    #: Largest torque against rolling per normal force [m], in the frame-rate method; a pair has the
    #: larger of its two. Without it 0.0.
    rolling_friction: float | None = None
    #: Largest torque against spinning about the contact's normal per normal force [m], likewise.
    #: Without it 0.0.
    spinning_friction: float | None = None
    #: In [0, 1]; a pair has the smaller of its two. Without it 0.5.
    restitution: float | None = None
    #: Fracture of the body, if breakable.
    breaking: Breaking | None = None
    #: Glue between the pieces of a glued body.
    bonds: Bonds | None = None
    #: Appearance in pictures and files; no effect on physics.
    look: Look | OwnLook | None = None
    #: Decides density, friction, restitution, strength, pattern and look, as far as the body does
    #: not: a preset (concrete, glass, brick, masonry, wood, ice, steel), one of the scene's, or one
    #: given here.
    material: str | Material | None = None


@dataclass(slots=True)
class SceneDesc(Description):
    """Initial state of a world. SI units, y up."""

    #: In the order in which they enter the world.
    bodies: list[Body]

    _: KW_ONLY
    #: For reports and files.
    name: str | None = None
    #: Up to 1e4 along each axis [m/s^2]. Without it [0.0, -9.81, 0.0].
    gravity: Numbers | None = None
    #: One step each; from 1 to 1e5. Without it 30.0.
    frames_per_second: float | None = None
    #: Method of the step. Without it 'frame-rate'.
    method: Method | None = None
    #: Let islands sleep in the frame-rate method: bodies at rest for half a second sleep until the
    #: next contact, and need no solving. Off, all bodies are awake in every frame. Without it
    #: false.
    sleep: bool | None = None
    #: Trade-offs between accuracy and time of the frame-rate method.
    solver: Solver | None = None
    #: Default number of frames of `frangible run`; without it, three seconds' worth.
    frames: int | None = None
    #: Materials of one's own, by name.
    materials: dict[str, Material] | None = None
