"""USD: one Mesh prim for every body, under an Xform for the body of the scene that it was a part
of."""

from __future__ import annotations

import errno
import math
import os
import tempfile
from collections.abc import Callable
from typing import Any

import numpy as np
from pxr import Gf, Kind, Sdf, Tf, Usd, UsdGeom, UsdShade, UsdUtils, Vt

from ..convention import Convention
from ..errors import CacheError
from ..names import by_source, unique_names
from ..pieces import Pieces
from ..recording import Body, Recording
from ..render.ground import with_visible_ground
from ..render.normals import corner_normals, shaded_mesh
from ..render.palette import Palette
from .image_folder import ImageFolder
from .usd_cameras import write_camera
from .usd_materials import add_material
from .usd_motion import Timing, extent_of_all, write_life, write_motion, write_velocities
from .usd_stage import mark, open_stage, written_as
from .usd_tree import PrimTree, root_name
from .whole import whole_path

#: Poses that the library holds in memory before they go to a file, at some 600 bytes each.
UNSAVED = 2**13
#: The marker of a stage that a recording was written as.
RECORDING = "recording"


def write_usd(
    recording: Recording, path: str, geometry: str | None = None, late: float = 0.0
) -> None:
    """Write ``.usda`` or ``.usdc``; time codes are frames, masses kilograms; units and axes are the
    recording's convention.

    With ``geometry``, surfaces and materials go into that file, which the stage has as a sublayer:
    what moves is in a small layer of its own. Bodies appear and vanish so much ``late`` [frames].
    """
    with tempfile.TemporaryDirectory(dir=os.path.dirname(os.path.abspath(path))) as folder:
        # A binary file grows sample by sample; a text is written from one at once.
        is_text = path.endswith(".usda")
        draft = os.path.join(folder, "motion.usdc") if is_text else path
        _write_layers(recording, draft, path, geometry, late)
        # Read again, its samples stay in its file.
        motion = Sdf.Layer.FindOrOpen(draft)
        if geometry is not None:
            # The files take their names when both are whole.
            motion.subLayerPaths[:] = [f"./{os.path.basename(whole_path(geometry))}"]
        _save(lambda: motion.Export(path) if is_text else motion.Save())


def _write_layers(
    recording: Recording, draft: str, path: str, geometry: str | None, late: float
) -> None:
    """Write what moves into a draft, and the surfaces of a stage at a path into that of the
    geometry; without one into the same."""
    stage = Usd.Stage.CreateNew(draft)
    motion = stage.GetRootLayer()
    convention = recording.convention
    _say_conventions(stage, recording)
    bodies = with_visible_ground(recording).bodies
    families = by_source(bodies)
    root = root_name([family[0].name for family in families.values()])
    motion.defaultPrim = root
    shapes = motion if geometry is None else _layer_below(stage, geometry)
    tree = PrimTree(stage, root)
    top = _root(stage, tree.root, convention)
    materials = tree.child(tree.root, "Materials")
    UsdGeom.Scope.Define(stage, materials)

    # One Xform for each source, with its pieces; their motion in its own layer.
    images = ImageFolder(f"{os.path.splitext(whole_path(path))[0]}_textures")
    palette = Palette(
        families,
        lambda name, material: add_material(stage, f"{materials}/{name}", material, images),
    )
    timing = Timing(convention.first_frame, recording.fps, late)
    unsaved = 0
    for family in families.values():
        source = tree.source(family[0].name)
        for body in family:
            mesh = _mesh(stage, tree.body(source, body, family[0].name), body, palette)
            with Usd.EditContext(stage, motion):
                write_motion(mesh, body, timing)
                write_life(mesh, body, timing)
                write_velocities(mesh, body, timing)
            # What is saved is read back from the file when somebody asks.
            unsaved += len(body.positions)
            if unsaved > max(UNSAVED, 4 * len(bodies)):
                _save(motion.Save)
                unsaved = 0
    with Usd.EditContext(stage, motion):
        UsdGeom.ModelAPI.Apply(top.GetPrim()).SetExtentsHint(extent_of_all(bodies))
        for camera in convention.cameras:
            write_camera(stage, tree.camera(camera.name), camera, convention, recording.fps)
    _save(motion.Save)
    if geometry is not None:
        _save(shapes.Save)


def _say_conventions(stage: Any, recording: Recording) -> None:
    """Axes, units and times."""
    convention = recording.convention
    is_z_up = convention.up_axis == "z"
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z if is_z_up else UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, convention.metres)
    stage.SetMetadata("kilogramsPerUnit", 1.0)
    stage.SetTimeCodesPerSecond(recording.fps)
    stage.SetFramesPerSecond(recording.fps)
    stage.SetStartTimeCode(convention.first_frame)
    stage.SetEndTimeCode(convention.first_frame + recording.frames)
    mark(stage, RECORDING)


def _layer_below(stage: Any, path: str) -> Any:
    """A new layer that says of axes and units what the stage says; what is defined goes there."""
    layer = Sdf.Layer.CreateNew(path)
    layer.TransferContent(stage.GetRootLayer())
    layer.customLayerData = {}
    stage.GetRootLayer().subLayerPaths.append(layer.identifier)
    stage.SetEditTarget(layer)
    return layer


def _root(stage: Any, path: str, convention: Convention) -> Any:
    """The root prim; what is below is in metres, y up."""
    top = UsdGeom.Xform.Get(stage, path)
    Usd.ModelAPI(top.GetPrim()).SetKind(Kind.Tokens.component)
    if convention.up_axis == "z":
        top.AddRotateXOp().Set(90.0)
    if convention.metres != 1.0:
        top.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(1.0 / convention.metres))
    return top


def write_usdz(recording: Recording, path: str) -> None:
    """The same as one file, with its images in it."""
    with tempfile.TemporaryDirectory() as folder:
        stem = os.path.splitext(os.path.basename(whole_path(path)))[0]
        stage = os.path.join(folder, f"{stem}.usdc")
        write_usd(recording, stage)
        _save(lambda: UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(stage), path))


def geometry_path(path: str) -> str:
    """Where the surfaces of a stage at a path are."""
    stem, ending = os.path.splitext(path)
    return f"{stem}.geometry{ending}"


def write_pieces(pieces: Pieces, path: str) -> None:
    """Write a broken mesh: a Mesh for each piece, with its origin at its centre of mass."""
    stage = Usd.Stage.CreateNew(path)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    (name,) = unique_names([pieces.name])
    root = UsdGeom.Xform.Define(stage, f"/{name}")
    Usd.ModelAPI(root.GetPrim()).SetKind(Kind.Tokens.component)
    stage.SetDefaultPrim(root.GetPrim())
    UsdGeom.Scope.Define(stage, f"/{name}/Materials")
    images = ImageFolder(f"{os.path.splitext(whole_path(path))[0]}_textures")
    bodies = [piece.body(index) for index, piece in enumerate(pieces.pieces)]
    palette = Palette(
        by_source(bodies),
        lambda own, material: add_material(stage, f"/{name}/Materials/{own}", material, images),
        ("outer", "inner"),
    )
    tree = PrimTree(stage, name, ["Materials"])
    for body in bodies:
        write_motion(_mesh(stage, tree.body(tree.root, body, ""), body, palette), body, Timing())
    _save(stage.GetRootLayer().Save)


def _save(write: Callable[[], bool | None]) -> None:
    reason = "the USD library could not write all of it; is the disk full?"
    try:
        if write() is False:
            raise OSError(errno.EIO, reason)
    except Tf.ErrorException as error:
        raise OSError(errno.EIO, reason) from error


def _mesh(stage: Any, path: str, body: Body, palette: Palette[Any]) -> Any:
    # The surface, with normals of its own so that edges stay sharp and points stay shared.
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(body.vertices, np.float32)))
    mesh.CreateFaceVertexCountsAttr(
        Vt.IntArray.FromNumpy(np.full(len(body.triangles), 3, np.int32))
    )
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(body.triangles.ravel().astype(np.int32)))
    if body.skin is not None:
        shown = np.unique(body.skin.material[body.skin.material >= 0]).tolist()
        if any(body.skin.materials[index].double_sided for index in shown):
            mesh.CreateDoubleSidedAttr(True)
    low, high = body.vertices.min(axis=0).tolist(), body.vertices.max(axis=0).tolist()
    mesh.CreateExtentAttr([Gf.Vec3f(*low), Gf.Vec3f(*high)])
    _add_primvars(mesh, body)
    _bind_materials(mesh, body, palette)
    return mesh


def _add_primvars(mesh: Any, body: Body) -> None:
    """Normals, texture coordinates and colours of a body's corners."""
    shaded = shaded_mesh(body.vertices, body.triangles, body.interior)
    primvars = UsdGeom.PrimvarsAPI(mesh)
    normals = primvars.CreatePrimvar(
        "normals", Sdf.ValueTypeNames.Normal3fArray, UsdGeom.Tokens.faceVarying
    )
    if body.skin is None or body.skin.normals is None:
        normals.Set(Vt.Vec3fArray.FromNumpy(shaded.normals))
        normals.SetIndices(Vt.IntArray.FromNumpy(shaded.triangles.ravel().astype(np.int32)))
    else:
        normals.Set(
            Vt.Vec3fArray.FromNumpy(
                np.ascontiguousarray(corner_normals(body, shaded).reshape(-1, 3))
            )
        )

    coordinates = primvars.CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying
    )
    coordinates.Set(
        Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(body.coordinates.reshape(-1, 2), np.float32))
    )
    if body.skin is not None and body.skin.colours is not None:
        colours = np.ascontiguousarray(body.skin.colours.reshape(-1, 4), np.float32)
        mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.faceVarying).Set(
            Vt.Vec3fArray.FromNumpy(colours[:, :3].copy())
        )
        if np.any(colours[:, 3] != 1.0):
            opacity = mesh.CreateDisplayOpacityPrimvar(UsdGeom.Tokens.faceVarying)
            opacity.Set(Vt.FloatArray.FromNumpy(colours[:, 3].copy()))


def _bind_materials(mesh: Any, body: Body, palette: Palette[Any]) -> None:
    """Crack faces have a material of their own, and the original surface keeps the mesh's; a subset
    for each."""
    groups = palette.groups(body)
    if not groups:
        return
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(groups[0][0])
    if len(groups) > 1:
        outer = sum(not is_inside for _, _, is_inside in groups)
        sides = [
            ("inside" if is_inside else "outside", outer if not is_inside else len(groups) - outer)
            for *_, is_inside in groups
        ]
        names = unique_names(
            side if count == 1 else group[0].GetPrim().GetName()
            for group, (side, count) in zip(groups, sides, strict=True)
        )
        for (material, faces, _), name in zip(groups, names, strict=True):
            subset = UsdShade.MaterialBindingAPI(mesh).CreateMaterialBindSubset(
                name,
                Vt.IntArray.FromNumpy(np.flatnonzero(faces).astype(np.int32)),
                UsdGeom.Tokens.face,
            )
            UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)


def describe_usd(path: str) -> dict[str, object] | None:
    """Frames, frame rate and bodies of a recording of ours; `None` for any other stage,
    `CacheError` if it is damaged."""
    with open_stage(path, CacheError) as stage:
        if written_as(stage) != RECORDING:
            return None
        beside = stage.GetRootLayer().subLayerPaths
        if len(stage.GetLayerStack(False)) <= len(beside):
            raise CacheError(f"{path}: needs the file {', '.join(beside)} beside it")
        frames = stage.GetEndTimeCode() - stage.GetStartTimeCode()
        fps = stage.GetTimeCodesPerSecond()
        if not (frames >= 0 and float(frames).is_integer() and 0 < fps < math.inf):
            raise CacheError(
                f"{path}: has {frames:g} frames at {fps:g} a second, must be a whole number and a "
                "rate > 0"
            )
        bodies = sum(prim.IsA(UsdGeom.Mesh) for prim in stage.Traverse())
        return {"frames": int(frames), "fps": fps, "bodies": bodies}
