"""Result of breaking a mesh: the pieces, and the report about them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, TypedDict

import numpy as np

from .recording import Body, Bool, Float32, Float64, UInt32
from .skin import Skin
from .words import counted


class Contact(TypedDict):
    """Where two pieces touched."""

    #: Indices of the two pieces.
    a: int
    b: int
    area_m2: float
    centroid_m: list[float]
    #: Unit, from ``a`` to ``b``.
    normal: list[float]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Piece:
    """A part of a mesh, in the mesh's frame."""

    name: str
    #: (v, 3) [m].
    vertices: Float64
    #: (t, 3) vertex indices, counter-clockwise seen from outside.
    triangles: UInt32
    #: (t,) whether a crack made the triangle.
    inner: Bool
    #: (t, 3, 2) texture coordinates of the corners, v up: the file's on the mesh's own surface
    #: where it has some, else metres, in the plane of the crack or along the axis that the surface
    #: faces.
    coordinates: Float32
    #: [m^3].
    volume: float
    #: (3,) centre of mass [m].
    center: Float64
    #: (3, 3) about the centre of mass, at unit density [m^5].
    unit_inertia: Float64
    #: Attributes of the mesh's file; `None` if it says nothing.
    skin: Skin | None = None

    def __repr__(self) -> str:
        return f"<Piece {self.name!r}, {self.volume:.3g} m^3, {len(self.triangles)} triangles>"

    def body(self, index: int) -> Body:
        """As a body at rest, for the writers of recordings."""
        return Body(
            id=index,
            name=self.name,
            parent=None,
            source=0,
            birth_frame=0,
            death_frame=None,
            mass=self.volume,
            look=None,
            vertices=(self.vertices - self.center).astype(np.float32),
            triangles=self.triangles,
            interior=self.inner,
            coordinates=self.coordinates,
            positions=self.center[None],
            orientations=np.array([[0.0, 0.0, 0.0, 1.0]]),
            skin=self.skin,
        )


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Pieces:
    """A broken mesh."""

    #: Of the mesh: its file without folder and ending.
    name: str
    pieces: list[Piece]
    #: Each pair of neighbours once.
    contacts: list[Contact]
    #: Of what was broken [m^3]: the mesh as it was closed or sampled.
    volume: float
    #: Where the pattern's centre lay, and the direction from there towards what strikes (3,).
    at: Float64
    normal: Float64
    #: Repairs of the mesh before it was cut, in sentences.
    notes: list[str] = field(default_factory=list)

    def __repr__(self) -> str:
        return f"<{len(self.pieces)} pieces of {self.name!r}, {self.volume:.3g} m^3>"

    @property
    def volume_defect(self) -> float:
        """How far the pieces' volumes are from adding up, relative to the whole."""
        return abs(math.fsum(piece.volume for piece in self.pieces) - self.volume) / self.volume

    def report(self) -> dict[str, Any]:
        """All numbers, for JSON."""
        neighbours: list[list[dict[str, Any]]] = [[] for _ in self.pieces]
        for contact in self.contacts:
            for own, other, sign in (
                (contact["a"], contact["b"], 1.0),
                (contact["b"], contact["a"], -1.0),
            ):
                neighbours[own].append(
                    {
                        "name": self.pieces[other].name,
                        "area_m2": contact["area_m2"],
                        "centroid_m": contact["centroid_m"],
                        "normal": [sign * component for component in contact["normal"]],
                    }
                )
        return {
            "mesh": self.name,
            "at_m": self.at.tolist(),
            "normal": self.normal.tolist(),
            "notes": self.notes,
            "volume_m3": self.volume,
            "volume_defect": self.volume_defect,
            "pieces": [
                {
                    "name": piece.name,
                    "volume_m3": piece.volume,
                    "center_m": piece.center.tolist(),
                    "unit_inertia_m5": piece.unit_inertia.tolist(),
                    "low_m": piece.vertices.min(axis=0).tolist(),
                    "high_m": piece.vertices.max(axis=0).tolist(),
                    "neighbours": around,
                }
                for piece, around in zip(self.pieces, neighbours, strict=True)
            ],
        }

    def summary(self, seconds: float) -> dict[str, Any]:
        """The report in short."""
        volumes = [piece.volume for piece in self.pieces]
        return {
            "mesh": self.name,
            "pieces": len(self.pieces),
            "contacts": len(self.contacts),
            "volume_m3": self.volume,
            "volume_defect": self.volume_defect,
            "largest_m3": max(volumes, default=0.0),
            "smallest_m3": min(volumes, default=0.0),
            "notes": self.notes,
            "seconds": seconds,
        }


def describe_pieces(summary: dict[str, Any]) -> str:
    """A summary for people."""
    whole = summary["volume_m3"]
    lines = [
        *summary["notes"],
        f"{counted(summary['pieces'], 'piece')} of {summary['mesh']} in {summary['seconds']:.2g} s,"
        f" {counted(summary['contacts'], 'contact')}",
        f"volume {whole:.6g} m^3; the pieces' add up to it within {summary['volume_defect']:.1g}",
        f"largest piece {summary['largest_m3'] / whole:.2%}, smallest "
        f"{summary['smallest_m3'] / whole:.2g} of it",
    ]
    return "\n".join(lines)
