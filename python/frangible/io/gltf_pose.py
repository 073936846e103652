"""Nodes, joints and morph targets of a glTF document at some time."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .gltf_document import Array, Document, Json

Float64 = npt.NDArray[np.float64]


def pose(document: Document, time: float) -> None:
    """Write what the document's first animation says at a time [s] into its nodes."""
    animations = document.items("animations")
    for channel in animations[0].get("channels", []) if animations else []:
        target = channel["target"]
        if "node" not in target or target["path"] not in (
            "translation",
            "rotation",
            "scale",
            "weights",
        ):
            continue
        sampler = animations[0]["samplers"][channel["sampler"]]
        times = document.accessor(sampler["input"]).astype(np.float64).ravel()
        values = document.accessor(sampler["output"]).astype(np.float64)
        if len(times) == 0 or len(values) % len(times):
            raise document.fail("an animation has not as many values as times")
        rows = values.reshape(len(times), -1)
        value = _sample(
            times,
            rows,
            time,
            str(sampler.get("interpolation", "LINEAR")),
            target["path"] == "rotation",
        )
        node = document.item("nodes", target["node"])
        node.pop("matrix", None)
        node[target["path"]] = value.tolist()


def _sample(times: Float64, rows: Float64, time: float, interpolation: str, turns: bool) -> Float64:
    """A value between two keys; before the first and after the last it is theirs."""
    is_cubic = interpolation == "CUBICSPLINE"
    keys = rows.reshape(len(times), 3, -1) if is_cubic else rows[:, None, :]
    middle = 1 if is_cubic else 0
    after = int(np.searchsorted(times, time, side="right"))
    if after == 0 or after == len(times):
        return np.asarray(keys[min(after, len(times) - 1), middle], np.float64)
    span = times[after] - times[after - 1]
    t = (time - times[after - 1]) / span
    a, b = keys[after - 1, middle], keys[after, middle]
    if interpolation == "STEP":
        return np.asarray(a, np.float64)
    if is_cubic:
        value = (
            (2 * t**3 - 3 * t**2 + 1) * a
            + (t**3 - 2 * t**2 + t) * span * keys[after - 1, 2]
            + (3 * t**2 - 2 * t**3) * b
            + (t**3 - t**2) * span * keys[after, 0]
        )
    elif turns:
        value = _between_turns(a, b, t)
    else:
        value = (1 - t) * a + t * b
    return np.asarray(value / np.linalg.norm(value) if turns else value, np.float64)


def _between_turns(a: Float64, b: Float64, t: float) -> Float64:
    """From one quaternion to another along the shorter way, at a steady rate."""
    b = -b if a @ b < 0.0 else b
    angle = np.arccos(np.clip(a @ b, -1.0, 1.0))
    if angle < 1e-6:
        return (1 - t) * a + t * b
    return np.asarray((np.sin((1 - t) * angle) * a + np.sin(t * angle) * b) / np.sin(angle))


def matrix(node: Json) -> Float64:
    """`parent_from_node` (4, 4), columns are multiplied."""
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    return placed(
        node.get("translation", (0, 0, 0)),
        node.get("rotation", (0, 0, 0, 1)),
        node.get("scale", (1, 1, 1)),
    )


def placed(translation: Any, rotation: Any, scale: Any) -> Float64:
    """The matrix (4, 4) of a translation, a quaternion x, y, z, w and a scale; of rows of them
    matrices (n, 4, 4)."""
    quaternion = np.asarray(rotation, np.float64)
    lengths = np.linalg.norm(quaternion, axis=-1, keepdims=True)
    x, y, z, w = np.moveaxis(quaternion / np.where(lengths == 0.0, 1.0, lengths), -1, 0)
    turned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    columns = np.moveaxis(turned, (0, 1), (-2, -1)) * np.asarray(scale, np.float64)[..., None, :]
    made = np.zeros((*columns.shape[:-2], 4, 4))
    made[..., :3, :3] = columns
    made[..., :3, 3] = translation
    made[..., 3, 3] = 1.0
    return made


def world_matrices(document: Document) -> list[Float64]:
    """`scene_from_node` of each node; one that is in no scene is where it would be as a root."""
    nodes = document.items("nodes")
    parents: dict[int, int] = {}
    for number, node in enumerate(nodes):
        for child in node.get("children", []):
            document.item("nodes", child)
            if parents.setdefault(child, number) != number:
                raise document.fail(f"node {child} is the child of more than one node")
    worlds: dict[int, Float64] = {}
    for number in range(len(nodes)):
        # Up to what is known, then down again.
        path = [number]
        while path[-1] not in worlds and path[-1] in parents:
            path.append(parents[path[-1]])
            if len(path) > len(nodes):
                raise document.fail(f"node {number} is below itself")
        for step in reversed(path):
            if step not in worlds:
                above = worlds[parents[step]] if step in parents else np.eye(4)
                worlds[step] = above @ matrix(nodes[step])
    return [worlds[number] for number in range(len(nodes))]


def morphed(
    document: Document, primitive: Json, name: str, base: Float64, weights: list[float]
) -> Float64:
    """An attribute with what its morph targets add."""
    for target, weight in zip(primitive.get("targets", []), weights, strict=False):
        if weight and name in target:
            added = document.accessor(target[name])
            if added.shape != base.shape:
                raise document.fail("a morph target has not as many vertices as its primitive")
            base = base + weight * added
    return base


def joint_matrices(document: Document, skin: Json, worlds: list[Float64]) -> Float64:
    """`scene_from_bind` (j, 4, 4) of each joint."""
    joints = skin["joints"]
    matrices = np.array([worlds[_checked(document, joint)] for joint in joints]).reshape(-1, 4, 4)
    if "inverseBindMatrices" in skin:
        inverse = document.accessor(skin["inverseBindMatrices"]).astype(np.float64)
        if len(inverse) < len(joints):
            raise document.fail("a skin has fewer matrices than joints")
        matrices = matrices @ inverse[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
    return matrices


def _checked(document: Document, node: Any) -> int:
    document.item("nodes", node)
    return int(node)


def skinning(
    document: Document, attributes: Json, joints: Float64, vertices: int, unpacked: dict[str, Array]
) -> Float64:
    """The blend (v, 4, 4) of the joints' matrices that each vertex follows; what is unpacked
    already is taken from there."""

    def rows(name: str) -> Array:
        return unpacked[name] if name in unpacked else document.accessor(attributes[name])

    blend = np.zeros((vertices, 4, 4))
    total = np.zeros(vertices)
    number = 0
    while f"JOINTS_{number}" in attributes and f"WEIGHTS_{number}" in attributes:
        which = rows(f"JOINTS_{number}").astype(np.int64)
        weights = rows(f"WEIGHTS_{number}").astype(np.float64)
        if (
            which.shape != (vertices, 4)
            or weights.shape != which.shape
            or np.any(which >= len(joints))
        ):
            raise document.fail("the joints of a primitive do not fit its skin")
        for column in range(4):
            blend += weights[:, column, None, None] * joints[which[:, column]]
        total += weights.sum(axis=1)
        number += 1
    # A vertex that no joint holds follows the first one.
    free = ~(total > 0.0)
    blend[free], total[free] = joints[0], 1.0
    return blend / total[:, None, None]
