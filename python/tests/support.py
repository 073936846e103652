"""A small world with a known answer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from frangible import Recording
from frangible.recording import Body
from frangible.render.camera import Camera

#: Width over height of pictures.
ASPECT = 16 / 9
TOOLS = Path(__file__).parents[2] / "tests" / "tools"

CUBE_VERTICES = (
    np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float32) / 2
)
CUBE_TRIANGLES = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5],  # x
        [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6],  # y
        [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],  # z
    ],
    np.uint32,
)  # fmt: skip


class ScriptedWorld:
    """A slab of 2 m falls; at frame 3 it breaks into two cubes, of which one breaks again within
    the same frame.

    Bodies: 0 ground (static, flat and wide), 1 slab; 2 and 3 its halves, of which 3 is never seen;
    4 and 5 those of 3.
    """

    dt = 1 / 24
    method = "paper"

    def __init__(self) -> None:
        self.frame = 0

    def step(self) -> dict[str, Any]:
        self.frame += 1
        fractures = []
        if self.frame == 3:
            fractures = [{"body": 1, "fragments": [2, 3]}, {"body": 3, "fragments": [4, 5]}]
        return {"frame": self.frame, "bodies": len(self.ids), "fractures": fractures}

    @property
    def ids(self) -> Any:
        return np.array([0, 1] if self.frame < 3 else [0, 2, 4, 5], np.uint64)

    @property
    def positions(self) -> Any:
        across = {0: 0.0, 1: 0.0, 2: -0.5, 4: 0.25, 5: 0.75}
        height = {0: -0.5, 5: 1.0}
        return np.array(
            [[across[i], height.get(i, 4.0 - 0.5 * self.frame), 0.0] for i in self.ids.tolist()]
        )

    @property
    def orientations(self) -> Any:
        # Body 2 turns by a quarter in each frame, and its quaternion's sign alternates.
        turning = np.array(
            [0.0, np.sin(np.pi / 4 * self.frame), 0.0, np.cos(np.pi / 4 * self.frame)]
        )
        still = np.array([0.0, 0.0, 0.0, 1.0])
        return np.array(
            [turning * (-1) ** self.frame if i == 2 else still for i in self.ids.tolist()]
        )

    @property
    def masses(self) -> Any:
        return np.array([{0: np.inf, 1: 2.0, 2: 1.0}.get(i, 0.5) for i in self.ids.tolist()])

    @property
    def volumes(self) -> Any:
        return np.where(np.isfinite(self.masses), 1e-3 * self.masses, 0.0)

    @property
    def names(self) -> list[str]:
        return [{0: "ground", 1: "slab"}.get(i, f"slab.{i}") for i in self.ids.tolist()]

    @property
    def parents(self) -> list[int | None]:
        return [{2: 1, 4: 3, 5: 3}.get(i) for i in self.ids.tolist()]

    @property
    def looks(self) -> list[str | None]:
        return ["glass" if i == 5 else None for i in self.ids.tolist()]

    def material_frame(self, body_id: int) -> tuple[list[float], list[float]]:
        """The slab's own frame, seen from each of its parts."""
        middle = {2: -0.5, 4: 0.25, 5: 0.75}.get(body_id, 0.0)
        return [-middle, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]

    def surface(self, body_id: int) -> tuple[Any, Any, Any, Any]:
        size = {0: [99, 1, 99], 1: [2, 1, 1], 2: [1, 1, 1]}.get(body_id, [0.5, 1, 1])
        # The cracks are perpendicular to x.
        interior = np.zeros(12, bool)
        interior[{2: slice(2, 4), 4: slice(0, 4), 5: slice(0, 2)}.get(body_id, slice(0))] = True
        vertices = (CUBE_VERTICES * np.array(size)).astype(np.float32)
        # Each triangle is laid out across the axis that it faces.
        corners = vertices[CUBE_TRIANGLES]
        flat = [np.delete(three, np.argmin(np.ptp(three, axis=0)), axis=1) for three in corners]
        return vertices, CUBE_TRIANGLES, interior, np.array(flat, np.float32)


def box(
    body_id: int,
    path: list[list[float]] | np.ndarray,
    size: list[float],
    *,
    born: int = 0,
    died: int | None = None,
    parent: int | None = None,
    mass: float = 1.0,
) -> Body:
    positions = np.array(path, np.float64)
    return Body(
        id=body_id,
        name=f"box{body_id}",
        parent=parent,
        source=body_id if parent is None else parent,
        birth_frame=born,
        death_frame=died,
        mass=mass,
        look=None,
        vertices=(CUBE_VERTICES * np.array(size)).astype(np.float32),
        triangles=CUBE_TRIANGLES,
        interior=np.zeros(12, np.bool_),
        coordinates=np.zeros((12, 3, 2), np.float32),
        positions=positions,
        orientations=np.tile([0.0, 0.0, 0.0, 1.0], (len(positions), 1)),
    )


def shot(bodies: list[Body], frames: int) -> Recording:
    return Recording("shot", "frame-rate", 30.0, frames, bodies)


def on_picture(camera: Camera, points: np.ndarray) -> np.ndarray:
    """Places (n, 2) in the picture, from -1 to 1 across its height and width."""
    local = (points - camera.eye) @ camera.axes.T
    assert np.all(local[:, 2] > 0.0)
    half = camera.half_height * np.array([ASPECT, 1.0])
    return local[:, :2] / local[:, 2:] / half
