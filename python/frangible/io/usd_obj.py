"""Parts of a USD stage as one OBJ file."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..recording import Float64
from .usd_looks import said_of
from .usd_part import Part


def write_obj(path: str, parts: list[Part], time: Any) -> None:
    """All parts, with what their prims say besides."""
    vertex = place = normal = 1
    with open(path, "w", encoding="utf-8") as file:
        for part in parts:
            said = said_of(part, time)
            points, corners = part.points, part.corners
            lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
            if said.colours is not None:
                # A vertex for each corner, as colours are the vertices'. Files of vertices have
                # them in sRGB.
                points, corners = points[corners], np.arange(len(corners))
                rows = np.concatenate([points, _srgb(said.colours)], axis=1).tolist()
                lines = [
                    f"v {x!r} {y!r} {z!r} {r:.9g} {g:.9g} {b:.9g}" for x, y, z, r, g, b in rows
                ]
            words = [(corners + vertex).astype(str)]
            if said.coordinates is not None:
                lines += [f"vt {u:.9g} {v:.9g}" for u, v in said.coordinates.tolist()]
                words.append((np.arange(len(corners)) + place).astype(str))
                place += len(corners)
            if said.normals is not None:
                lines += [f"vn {x:.9g} {y:.9g} {z:.9g}" for x, y, z in said.normals.tolist()]
                words += [np.full(len(corners), "")] if said.coordinates is None else []
                words.append((np.arange(len(corners)) + normal).astype(str))
                normal += len(corners)
            file.write(f"o {part.name}\n" + "\n".join(lines) + "\n")
            named = [
                "/".join(parts_of)
                for parts_of in zip(*(word.tolist() for word in words), strict=True)
            ]
            material = ""
            ends = np.cumsum(part.counts).tolist()
            for end, count, own in zip(ends, part.counts.tolist(), said.materials, strict=True):
                if own != material:
                    material = own
                    file.write(f"usemtl {own}\n")
                file.write(f"f {' '.join(named[end - count : end])}\n")
            file.write("usemtl\n")
            vertex += len(points)


def _srgb(linear: Float64) -> Float64:
    """Channels from 0 to 1 with sRGB's transfer function."""
    clipped = np.maximum(linear, 0.0)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1.0 / 2.4) - 0.055)
