"""Scenes as dataclasses, with their files."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Self

from ._frangible import BuildError
from .errors import OutputError
from .extras import missing_packages
from .io.mesh_files import USD_ENDINGS
from .io.toml_text import as_toml
from .io.whole import whole_file
from .scene_fields import with_relative_paths
from .scene_types import SceneDesc
from .scenes import TEXT_ENDINGS, as_json, read_scene

#: Endings of the files that scenes are written to.
WRITTEN = (*TEXT_ENDINGS, *USD_ENDINGS[:3])


@dataclass(slots=True)
class Scene(SceneDesc):
    """A scene: bodies, gravity and how they are simulated. SI units, y up."""

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """The scene of a file; `BuildError` if it is none."""
        return cls.from_dict(read_scene(path))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the scene as .json, .toml or USD; `OutputError` for another ending."""
        save_scene(self.to_dict(), path)


def save_scene(scene: dict[str, Any], path: str | os.PathLike[str]) -> None:
    """Write a scene in the format of the path's ending; `OutputError` for another one, `BuildError`
    for a scene that is none."""
    name = os.fspath(path)
    ending = os.path.splitext(name)[1].lower()
    if ending not in WRITTEN:
        rule = f"must end in {', '.join(WRITTEN[:-1])} or {WRITTEN[-1]}"
        raise OutputError(f"{name}: ends in {ending!r}, {rule}")
    if ending in USD_ENDINGS:
        if hint := missing_packages("usd"):
            raise OutputError(f"{name}: {hint}")
        from .io.usd_scene_out import write_usd_scene

        if not isinstance(scene.get("bodies"), list):
            raise BuildError("bodies: missing, must be a list of objects")
        with whole_file(name) as part:
            write_usd_scene(scene, part, name)
        return
    fields = with_relative_paths(scene, name)
    text = as_toml(fields) if ending == ".toml" else f"{as_json(fields)}\n"
    with whole_file(name) as part, open(part, "w", encoding="utf-8") as file:
        file.write(text)
