"""The [[model]] tables of a TOML scene: which file, its units, where it stands, what of it is used."""

from __future__ import annotations

from dataclasses import replace
from math import cos, radians, sin
from pathlib import Path

import numpy as np

from ...data import data_folder
from ..builtin import BUILTIN
from ..compose import droppable_names, flat_shaded, placed, untextured, without
from ..load import LOADERS, load_scene
from ..motion.tracks import Track
from ..scene import Scene
from .fields import Table, nearest

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
"""Metres in each unit of length."""

DATA = "data:"
"""What a file name begins with that counts from the folder `scenes` of the data folder."""

KEYS = ("file", "unit", "up", "scale", "rotate", "translate", "matrix", "drop", "normals", "textures", "lights",
        "cameras", "clip")


def load_model(table: Table) -> Scene:
    """The scene that one [[model]] table describes, in world space. Raises SceneError."""
    table.allow(KEYS)
    matrix = _matrix(table)  # before the file is read, which may take long
    normals = table.choice("normals", ("shading", "flat"), "shading")
    textures, lights, cameras = (table.boolean(key, True) for key in ("textures", "lights", "cameras"))
    patterns = table.texts("drop")
    scene = _without(table, load_scene(_source(table)), patterns)
    if normals == "flat":
        scene = flat_shaded(scene)
    if not textures:
        scene = replace(scene, materials=[untextured(m) for m in scene.materials])
    scene = replace(scene, lights=scene.lights if lights else [], cameras=scene.cameras if cameras else [])
    kept = {("light", o.name) for o in scene.lights} | {("camera", o.name) for o in scene.cameras}
    tracks = [t for t in _playing(table, scene) if t.target in ("instance", "node") or (t.target, t.name) in kept]
    return placed(replace(scene, tracks=tracks), matrix)


def _playing(table: Table, scene: Scene) -> list[Track]:
    """The model's tracks; those of `clip` alone when that is given, which then plays whatever else does."""
    if "clip" not in table:
        return scene.tracks
    clip = table.choice("clip", scene.clips)
    return [replace(track, clip="") for track in scene.tracks if track.clip in ("", clip)]


def _source(table: Table) -> str | Path:
    """The name of a built-in scene, or a path to a file that exists."""
    name = table.text("file")
    if name in BUILTIN:
        return name
    path = file_path(table, "file", name)
    if path.is_dir():
        raise table.error("file", f"'{path}' is a folder", "name a file in it")
    if not path.is_file():
        within = name.rpartition("/")[0] + "/" if "/" in name else DATA if name.startswith(DATA) else ""
        beside = path.parent.iterdir() if path.parent.is_dir() else ()
        options = [within + file.name for file in beside if file.suffix.lower() in LOADERS]
        problem = f"there is no file '{path}' and no built-in scene of that name"
        raise table.error("file", problem, nearest(name, [*options, *BUILTIN]))
    return path


def file_path(table: Table, key: str, name: str) -> Path:
    """The file that `key` of the table names: beside the TOML file, or in the data folder. Raises SceneError."""
    if not name.startswith(DATA):
        return table.file.parent / name
    folder = data_folder() / "scenes"
    if not folder.is_dir():
        remedy = "set the environment variable OCTOLUX_DATA to the folder that holds 'scenes'"
        raise table.error(key, f"the data folder '{folder}' does not exist", remedy)
    return folder / name.removeprefix(DATA)


def _without(table: Table, scene: Scene, patterns: list[str]) -> Scene:
    try:
        return without(scene, patterns)
    except LookupError as error:
        pattern = str(error.args[0])
        problem = f"no group, mesh or material of the model is named '{pattern}'"
        raise table.error("drop", problem, nearest(pattern, droppable_names(scene))) from error


def _matrix(table: Table) -> np.ndarray:
    """float64 (4, 4), model file to world: unit and up first, then matrix, or scale, rotate and translate."""
    matrix = np.diag([_metres(table)] * 3 + [1.0])
    if table.choice("up", ("y", "z"), "y") == "z":
        matrix = _about((1.0, 0.0, 0.0), -90.0) @ matrix
    if "matrix" in table:
        return _given_matrix(table) @ matrix
    placing = np.eye(4)
    placing[:3, :3] = np.diag(_scale(table))
    placing = _rotation(table) @ placing
    placing[:3, 3] = table.numbers("translate", 3, (0.0, 0.0, 0.0))
    return placing @ matrix


def _metres(table: Table) -> float:
    unit = table.values.get("unit", "m")
    if not isinstance(unit, str):
        return table.number("unit", above=0.0)
    return UNITS[table.choice("unit", tuple(UNITS), "m")]


def _scale(table: Table) -> tuple[float, ...]:
    if isinstance(table.values.get("scale", 1.0), list):
        scale = table.numbers("scale", 3)
    else:
        scale = (table.number("scale", 1.0),) * 3
    if 0.0 in scale:
        raise table.error("scale", "is 0", "give numbers other than 0; leave objects out with 'drop'")
    return scale


def _rotation(table: Table) -> np.ndarray:
    """`rotate`: degrees about x, then y, then z, all fixed in the world; or {axis, degrees}."""
    if isinstance(table.values.get("rotate"), dict):
        turn = Table(table.file, f"{table.place}: rotate", table.values["rotate"])
        turn.allow(("axis", "degrees"))
        return _about(turn.direction("axis"), turn.number("degrees"))
    x, y, z = table.numbers("rotate", 3, (0.0, 0.0, 0.0))
    return _about((0, 0, 1), z) @ _about((0, 1, 0), y) @ _about((1, 0, 0), x)


def _given_matrix(table: Table) -> np.ndarray:
    for key in ("scale", "rotate", "translate"):
        if key in table:
            raise table.error(key, "stands beside 'matrix'", "give either 'matrix' or scale, rotate and translate")
    matrix = np.array(table.rows("matrix", (4,), lines=4))
    if (matrix[3] != (0.0, 0.0, 0.0, 1.0)).any():
        raise table.error("matrix", "its last row is not 0 0 0 1", "write it row by row, the translation on the right")
    if not abs(np.linalg.det(matrix[:3, :3])) > 0:
        raise table.error("matrix", "has no inverse: it flattens the model", "give a matrix whose axes are independent")
    return matrix


def _about(axis: tuple[float, float, float], degrees: float) -> np.ndarray:
    """float64 (4, 4): the rotation about `axis`, counter-clockwise when the axis points at the viewer (Rodrigues)."""
    x, y, z = np.asarray(axis, dtype=np.float64) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix = np.eye(4)
    matrix[:3, :3] += sin(radians(degrees)) * cross + (1.0 - cos(radians(degrees))) * cross @ cross
    return matrix
