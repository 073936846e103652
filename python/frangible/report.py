"""Report of one frame: the shape of the dictionaries that `World.step` answers with."""

from __future__ import annotations

from typing import NotRequired, TypedDict


class Causes(TypedDict):
    """Energy change of all dynamic bodies in the frame by cause [J]; the sum is E(n+1) - E(n)."""

    #: Kinematic bodies, and what a caller did between frames.
    work: float
    #: Impacts: the energy of an approach that restitution does not give back.
    collision: float
    #: Contacts that keep touching bodies from approaching.
    contact: float
    #: Coulomb's, rolling and spinning friction.
    friction: float
    #: Moving bodies out of each other.
    projection: float
    #: Breaking, which conserves: rounding.
    fracture: float
    #: Energy removed by the ledger.
    balance: float
    #: The remainder: flight and rotation, which conserve but for the rule by which bodies turn, and
    #: rounding.
    flight: float


class Energy(TypedDict):
    """Of all dynamic bodies at the end of the frame [J]."""

    kinetic: float
    #: Relative to the world's origin.
    potential: float
    total: float
    #: That kinematic bodies did in this frame, and a caller before it.
    work: float
    #: Growth of the ledger's banks in this frame: energy that was dissipated and may be spent
    #: again.
    banked: float
    #: Kinetic and potential energy with which waiting bodies started in this frame; E(n) counts it.
    #: Left out where an older version wrote the report.
    started: NotRequired[float]
    #: E(n+1) - E(n) - W, with what is in the banks counted as energy: what came out of nowhere in
    #: this frame, or, if negative, was dissipated.
    gain: float
    #: Components of E(n+1) - E(n).
    causes: Causes


class Balance(TypedDict):
    """Work of the ledger in the frame."""

    #: Of touching bodies.
    islands: int
    #: Islands in which the contacts that gave energy could pay it back.
    paid: int
    #: Islands whose relative velocities were scaled down.
    scaled: int
    #: Islands whose displacements were shortened.
    shortened: int
    #: Energy that was taken out, by payment, scaling or shortening [J].
    removed: float


class Momentum(TypedDict):
    """Of all dynamic bodies at the end of the frame, world frame."""

    #: [N s]
    linear: list[float]
    #: About the world's origin [N m s].
    angular: list[float]
    #: Change that neither gravity nor a static or kinematic body explains, relative to
    #: all momenta, since the world began.
    linear_error: float
    #: The same of angular momentum.
    angular_error: float


class Impulses(TypedDict):
    """Collision and contact impulses: how many were applied, shortened and dropped so that no
    energy came from them."""

    applied: int
    clamped: int
    discarded: int
    #: Energy that those would have made and did not [J].
    withheld: float


class Imbalance(TypedDict):
    """Relative differences between a body and the sum of its fragments."""

    mass: float
    momentum: float
    angular_momentum: float
    kinetic_energy: float


class RestPose(TypedDict):
    """Where a piece lay in its parent."""

    #: Of its centre of mass, in the parent's body frame [m].
    position: list[float]
    #: ``parent_from_piece``, a unit quaternion x, y, z, w.
    orientation: list[float]


class PieceContact(TypedDict):
    """The common surface of two pieces."""

    #: Both by their number in ``fragments``, the smaller first.
    pieces: list[int]
    #: [m^2]
    area: float
    #: Mean of its points, in the parent's body frame [m].
    point: list[float]
    #: Unit, from the first piece to the second, in the parent's body frame; the mean where the
    #: surface is not flat.
    normal: list[float]


class Fracture(TypedDict):
    """A body broke. Caches of format 5 and older have no ``time``, ``rest_poses`` and
    ``contacts``."""

    #: Start of the frame, when the pieces took the body's place [s].
    time: float
    #: The broken body; it lives no longer.
    body: int
    #: The striker.
    striker: int
    #: Where the two first touched on their way through the frame, world frame [m].
    point: list[float]
    #: The impulse that would have stopped the blow [N s].
    impulse: float
    #: The part that the body bore before it broke [N s].
    borne: float
    #: Energy that its cracks took from the motion of the two against each other [J].
    energy: float
    #: How many pieces its description asks for, if it does.
    wanted: NotRequired[int]
    #: As many came, without loose parts and slivers below a hundredth of the mean piece.
    counted: NotRequired[int]
    #: Its fragments.
    fragments: list[int]
    #: Where each fragment lay in the body.
    rest_poses: list[RestPose]
    #: Fragments that touched in the body, each pair once.
    contacts: list[PieceContact]
    imbalance: Imbalance


class Quarantined(TypedDict):
    """A body that was taken out of the world."""

    body: int
    #: The fault of its numbers.
    cause: str


class BorneBlow(TypedDict):
    """A blow that broke nothing."""

    #: The id of the body that bore it, and its name.
    body: int
    name: str
    #: The name of what struck it.
    striker: str
    #: Where, in the world [m].
    point: list[float]
    #: [N s]
    impulse: float
    #: What the body bears there, at least [N s]. A blow above it had too little energy for the
    #: cracks, or nothing to part.
    bears: float


class StepReport(TypedDict):
    """One frame."""

    #: Counts from 1.
    frame: int
    #: At the end of the frame [s].
    time: float
    #: Living bodies at the end of the frame.
    bodies: int
    #: How many of them slept in this frame, where the scene has ``"sleep": true``.
    asleep: int
    #: How many wait for their start at the end of the frame.
    waiting: NotRequired[int]
    #: Pairs of overlapping bounds that were not looked at, because too many bodies were in one
    #: place; 0 without such crowds.
    pairs_left_out: int
    #: Islands of bodies that took fewer substeps than they need, and overlap more:
    #: ``most_substeps`` bounds them, or the work of a frame if they are large.
    short_of_substeps: int
    #: Groups of islands with more impacts, or contacts to detect again, than a frame has time for:
    #: later impacts were stopped without bouncing, later contacts acted as they were first seen. 0
    #: but where bodies are crushed, rattle between others, or spin in crowds.
    short_of_impacts: int
    #: Of all dynamic bodies [kg].
    mass: float
    energy: Energy
    momentum: Momentum
    balance: Balance
    impulses: Impulses
    #: In order.
    fractures: list[Fracture]
    #: Of the blows that broke nothing the one that came nearest to what its body bears; not in the
    #: paper's method.
    borne: NotRequired[BorneBlow]
    #: Bodies whose numbers went bad and that were taken out of the world. Such a frame has no
    #: energy report.
    quarantined: list[Quarantined]
    #: Wall-clock time of each stage [ms], in order.
    stages: list[tuple[str, float]]
