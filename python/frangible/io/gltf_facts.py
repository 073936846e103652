"""What a binary glTF file of ours says of itself."""

from __future__ import annotations

import json
import struct

from .gltf import GENERATOR


def describe_glb(path: str) -> dict[str, object] | None:
    """Shot, frames, frame rate and bodies of a cache that `write_glb` wrote; `None` for any other
    file."""
    with open(path, "rb") as file:
        header = file.read(20)
        if len(header) < 20 or header[:4] != b"glTF":
            return None
        try:
            document = json.loads(file.read(struct.unpack("<I", header[12:16])[0]))
        except ValueError:
            return None
    if not isinstance(document, dict) or document.get("asset", {}).get("generator") != GENERATOR:
        return None
    bodies = sum(len(node.get("children", ())) for node in document["nodes"])
    return {**document["asset"]["extras"], "bodies": bodies}
