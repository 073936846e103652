"""Scenes of the user's own: from files, from the shots, and with fields set by hand."""

from __future__ import annotations

import copy
import json
import math
import os
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import replace
from typing import Any

from ._frangible import BuildError, shot_scene, shots
from .convention import Convention
from .description import Description
from .extras import missing_packages
from .io.gltf_mesh import ENDINGS as GLTF_ENDINGS
from .io.mesh_files import ENDINGS as MESH_ENDINGS
from .io.mesh_files import (
    USD_ENDINGS,
    check_ending,
    mesh_ending,
    readable_bodies,
    readable_mesh,
    stage_and_prim,
)
from .io.reading import file_fault
from .mesh_scene import UNITS, Wishes, mesh_scene
from .scene_fields import MOST_STEPS, set_field
from .scene_lines import FileScene, with_line
from .scene_looks import without_own_looks
from .scene_materials import has_materials, scene_materials_text, with_materials
from .scene_python import python_scene
from .scene_rate import set_rate
from .words import did_you_mean, shortened, shown

#: A scene as `docs/scene_format.md` describes it.
Scene = dict[str, Any]

#: Endings of scene files that are text.
TEXT_ENDINGS = (".json", ".toml")
#: Endings of scene files; those of USD are if there is physics in it.
ENDINGS = (*TEXT_ENDINGS, ".py", *USD_ENDINGS)

#: How long a scene runs that does not say how many frames it takes [s].
SECONDS = 3.0

#: A larger file is no scene [bytes].
LARGEST = 1 << 28

#: What Python does not read, as it takes a time that grows with the square of the digits.
_LONG_NUMBER = "holds a whole number of more than 4300 digits"
#: A dotted key of TOML with more than `MOST_STEPS` parts: its reader takes a time and a memory that
#: grow with their square.
_KEY = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_DEEP_KEY = re.compile(rf"(?<![\w.\-\"']){_KEY}(?:[ \t]*+\.[ \t]*+{_KEY}){{{MOST_STEPS},}}+")


def is_scene_file(name: str) -> bool:
    """True if this names a scene file, and not a shot: it ends like one, or has a folder."""
    return name.lower().endswith(ENDINGS) or "/" in name or os.sep in name


def is_mesh_file(name: str | os.PathLike[str]) -> bool:
    """True if this names a mesh file, or a stage without physics; `BuildError` if it is no
    stage."""
    path = os.fspath(name)
    ending = _ending(path)
    if ending not in USD_ENDINGS:
        return ending in MESH_ENDINGS
    if hint := missing_packages("usd"):
        raise BuildError(f"{path}: {hint}")
    from .io.usd_scene import is_physics_stage

    return not is_physics_stage(path)


def read_scene(path: str | os.PathLike[str]) -> Scene:
    """The scene of a .json, .toml, .py or USD file; what is relative in it is to the file's folder.
    `BuildError` if it is none."""
    name = os.fspath(path)
    ending = _ending(name)
    found = as_dict(
        _read_python(name)
        if ending == ".py"
        else _read_stage(name)
        if ending in USD_ENDINGS
        else _read_text(name)
    )
    if not isinstance(found, dict):
        raise BuildError(f"{name}: {shown(found)}, must be an object with the fields of a scene")
    folder = os.path.dirname(os.path.abspath(name))
    for holder in _path_holders(found):
        holder["path"] = os.path.join(folder, holder["path"])
    return found


def as_dict(scene: Any) -> Any:
    """A `Scene` as a dictionary; anything else as it is."""
    return scene.to_dict() if isinstance(scene, Description) else scene


def scene_of(body: Any, materials_text: str = "") -> Scene:
    """A scene that holds only a body, a `Body` or a dictionary, with the materials of another scene
    as JSON."""
    scene: Scene = {"bodies": [as_dict(body)]}
    return {**scene, "materials": json.loads(materials_text)} if materials_text else scene


class ReadableScene(Scene):
    """A scene that the core can build, with the materials that it had of its own as JSON; empty
    without any."""

    materials_text: str = ""


def _ending(name: str) -> str:
    return mesh_ending(name)


def _read_stage(name: str) -> Any:
    if hint := missing_packages("usd"):
        raise BuildError(f"{name}: {hint}")
    from .io.usd_scene import read_usd_scene

    read = read_usd_scene(name)
    scene = FileScene(read.fields)
    scene.name, scene.convention, scene.skins = name, read.convention, read.skins
    return scene


def _read_python(name: str) -> Any:
    if fault := file_fault(name):
        raise BuildError(f"{name}: {fault}")
    return copy.deepcopy(python_scene(name))


def _read_text(name: str) -> Any:
    """The value of a .json or .toml file, which knows its lines if it is an object."""
    try:
        with open(name, "rb") as file:
            content = file.read(LARGEST + 1)
    except FileNotFoundError:
        raise BuildError(f"{name}: no such file") from None
    except IsADirectoryError:
        raise BuildError(f"{name}: is a folder, must be a scene file") from None
    except OSError as error:
        raise BuildError(f"{name}: {error.strerror or error}") from None
    if len(content) > LARGEST:
        raise BuildError(f"{name}: is larger than {LARGEST >> 20} MiB, must be a scene file")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise BuildError(f"{name}: is not UTF-8 text, must be a scene in JSON or TOML") from None
    found = _parse_toml(name, text) if name.lower().endswith(".toml") else parse_json(name, text)
    if not isinstance(found, dict):
        return found
    scene = FileScene(found)
    scene.name, scene.text = name, text
    return scene


def parse_json(name: str, text: str) -> Any:
    """The value of a JSON text; `BuildError` with line and column if it is none."""
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise BuildError(f"{name}: {where}: {error.msg}, must be JSON") from None
    except RecursionError:
        raise BuildError(f"{name}: is nested too deeply, must be a scene in JSON") from None
    except ValueError:
        raise BuildError(f"{name}: {_LONG_NUMBER}, must be a scene in JSON") from None


def _parse_toml(name: str, text: str) -> Any:
    if found := _DEEP_KEY.search(text):
        line = text.count("\n", 0, found.start()) + 1
        rule = f"must have at most {MOST_STEPS} parts"
        raise BuildError(f"{name}: line {line}: the key {shortened(found[0])}, {rule}")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise BuildError(f"{name}: {error}, must be TOML") from None
    except RecursionError:
        raise BuildError(f"{name}: is nested too deeply, must be a scene in TOML") from None
    except ValueError:
        raise BuildError(f"{name}: {_LONG_NUMBER}, must be a scene in TOML") from None


def _path_holders(scene: Scene) -> Iterator[dict[str, Any]]:
    """Everything in a scene that names a file."""
    bodies = scene.get("bodies")
    for body in bodies if isinstance(bodies, list) else []:
        for field, kind, *inner in (
            ("shape", "mesh"),
            ("breaking", "file", "pattern"),
            ("bonds", "file", "pattern"),
        ):
            holder = body.get(field) if isinstance(body, dict) else None
            for name in inner:
                holder = holder.get(name) if isinstance(holder, dict) else None
            if (
                isinstance(holder, dict)
                and holder.get("kind") == kind
                and isinstance(holder.get("path"), str)
            ):
                yield holder


@contextmanager
def readable_scene(scene: Any, pose_time: float | None = None) -> Iterator[Any]:
    """A scene that the core can build, from a `Scene`, JSON, a dictionary or a file's path, while
    the context lasts.

    Materials are resolved, and USD and glTF files read here, with what moves in them as it is at a
    pose time [s]. A `BuildError` of the context about a field of a file quotes its line.
    """
    if isinstance(scene, os.PathLike) or (
        isinstance(scene, str) and is_scene_file(scene) and "{" not in scene
    ):
        scene = read_scene(scene)
    elif isinstance(scene, str) and any(word in scene for word in _RESOLVED):
        scene = parse_json("scene", scene)
    given = scene = as_dict(scene)
    try:
        if has_materials(scene):
            scene = with_materials(scene)
        if isinstance(scene, dict):
            own = scene_materials_text(given)
            scene = ReadableScene(without_own_looks(scene))
            scene.materials_text = own
        if not isinstance(scene, dict) or not any(
            _is_converted(holder) for holder in _path_holders(scene)
        ):
            yield scene
            return
        scene = copy.deepcopy(scene)
        with ExitStack() as files:
            bodies: dict[str, list[tuple[dict[str, Any], str]]] = {}
            for holder in filter(_is_converted, _path_holders(scene)):
                path, prim = stage_and_prim(holder["path"])
                if prim is None:
                    holder["path"] = files.enter_context(readable_mesh(path, pose_time))
                else:
                    bodies.setdefault(path, []).append((holder, prim))
            # Each stage is opened once.
            for path, holders in bodies.items():
                prims = [prim for _, prim in holders]
                names = files.enter_context(readable_bodies(path, prims))
                for holder, prim in holders:
                    holder["path"] = names[prim]
            yield scene
    except BuildError as error:
        raise with_line(error, given) from None


#: What the text of a scene holds that the core does not resolve.
_RESOLVED = (".usd", *GLTF_ENDINGS, '"material', '"outside')


def _is_converted(holder: dict[str, Any]) -> bool:
    return _ending(holder["path"]) in (*USD_ENDINGS, *GLTF_ENDINGS)


def find_scene(
    source: str | os.PathLike[str] | Scene | Description,
    *,
    mesh: str | None = None,
    fps: float | None = None,
    method: str | None = None,
    seed: int | None = None,
    assignments: Iterable[str] = (),
    pose_time: float | None = None,
    pieces: int | None = None,
    thickness: float | None = None,
    wishes: Mapping[str, Any] | None = None,
) -> tuple[Scene, int, str]:
    """The scene of a shot, a file, a dictionary, or of a mesh file with fields of `Wishes`; with
    fields set as `set_field` does; how many frames it takes; its name.

    `BuildError` if there is none, or what is asked for does not fit it.
    """
    if isinstance(source, (str, os.PathLike)) and is_mesh_file(source):
        if mesh is not None:
            raise BuildError(f"mesh: {mesh}, must be left out for a mesh file")
        own: dict[str, Any] = {"pieces": pieces, "thickness": thickness, "seed": seed}
        scene = _mesh_scene(source, {**own, "frames_per_second": fps, **(wishes or {})})
        if method is not None:
            scene["method"] = method
        for assignment in assignments:
            set_field(scene, assignment)
        return scene, _frames(scene), _stem(source)
    for wish, value in (wishes or {}).items():
        option = {"origin": "from"}.get(wish, wish)
        raise BuildError(f"{option}: {value}, must come with a mesh file; see --set for scenes")
    if isinstance(source, str) and not is_scene_file(source):
        options = {"fps": fps, "method": method, "seed": seed, "thickness": thickness}
        scene = _shot(source, mesh, pose_time, options)
        _set_pieces(scene, pieces)
        for assignment in assignments:
            set_field(scene, assignment)
        return scene, _frames(scene), source
    for option, said in (("mesh", mesh), ("seed", seed), ("thickness", thickness)):
        if said is not None:
            raise BuildError(
                f"{option}: {said}, must be left out for a scene of one's own, which says it itself"
            )
    if isinstance(source, Description):
        source = source.to_dict()
    scene = copy.deepcopy(source) if isinstance(source, dict) else read_scene(source)
    if fps is not None:
        set_rate(scene, fps)
    if method is not None:
        scene["method"] = method
    _set_pieces(scene, pieces)
    for assignment in assignments:
        set_field(scene, assignment)
    name = scene.get("name") or ("scene" if isinstance(source, dict) else _stem(source))
    return scene, _frames(scene), str(name)


def _mesh_scene(path: str | os.PathLike[str], wishes: Mapping[str, Any]) -> Scene:
    given = {field: value for field, value in wishes.items() if value is not None}
    scene = FileScene(mesh_scene(path, Wishes(**given)).to_dict())
    scene.name = os.fspath(path)
    if _ending(scene.name) in USD_ENDINGS:
        from .io.usd_scene import stage_convention

        scene.convention = replace(stage_convention(scene.name), first_frame=0.0)
    else:
        unit = UNITS[wishes.get("unit") or "m"]
        scene.convention = Convention(wishes.get("up") or "y", unit)
    return scene


def _shot(name: str, mesh: str | None, pose_time: float | None, options: dict[str, Any]) -> Scene:
    if name not in dict(shots()) and os.path.exists(name):
        kind = "is a folder" if os.path.isdir(name) else "is no scene file"
        endings = f"{', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}"
        raise BuildError(f"{name}: {kind}, must end in {endings}, or be the name of a shot")
    known = dict(shots())
    if name not in known:
        rule = "must be one that `frangible shots` lists, a scene file or a mesh file"
        raise BuildError(f"unknown shot {name!r}{did_you_mean(name, known)}, {rule}")
    if mesh is not None:
        check_ending(mesh)
    with nullcontext() if mesh is None else readable_mesh(mesh, pose_time) as readable:
        scene: Scene = json.loads(shot_scene(name, mesh=readable, **options))
    # The reader of the scene reads the mesh's file too.
    for holder in _path_holders(scene):
        holder["path"] = mesh if holder["path"] == readable else holder["path"]
    return scene


def _set_pieces(scene: Scene, pieces: int | None) -> None:
    """Into how many pieces a break cuts each body that breaks; `BuildError` if none does."""
    if pieces is None:
        return
    bodies = scene.get("bodies")
    found = (
        [body.get("breaking") for body in bodies if isinstance(body, dict)]
        if isinstance(bodies, list)
        else []
    )
    breaking = [description for description in found if isinstance(description, dict)]
    if not breaking:
        raise BuildError(f"pieces: {pieces}, must come with a scene in which a body has 'breaking'")
    for description in breaking:
        description["pieces"] = pieces


def _stem(path: str | os.PathLike[str]) -> str:
    return os.path.splitext(os.path.basename(os.fspath(path)))[0]


def _frames(scene: Scene) -> int:
    """How many frames a scene takes; whether its numbers are any good, the engine says."""
    frames, rate = scene.get("frames"), scene.get("frames_per_second", 30.0)
    if isinstance(frames, int):
        return frames
    return math.ceil(SECONDS * rate) if isinstance(rate, (int, float)) and 0 < rate < 1e9 else 1


def as_json(scene: Scene) -> str:
    """The scene for people to read and change: rows of numbers stay in one line."""
    return _as_json(scene, "")


def _as_json(value: Any, indent: str) -> str:
    line = json.dumps(value)
    is_flat = isinstance(value, list) and not any(isinstance(item, (list, dict)) for item in value)
    if not isinstance(value, (list, dict)) or is_flat or len(indent) + len(line) <= 80:
        return line
    inner = indent + "  "
    if isinstance(value, dict):
        rows = [f"{inner}{json.dumps(key)}: {_as_json(item, inner)}" for key, item in value.items()]
        return "{\n" + ",\n".join(rows) + f"\n{indent}}}"
    return "[\n" + ",\n".join(inner + _as_json(item, inner) for item in value) + f"\n{indent}]"
