"""Scenes written by hand in TOML: models put together, with lights, cameras, materials and keyframes of their own.

docs/scenes.md lists the keys.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from math import radians
from pathlib import Path
from typing import Any

from ..cameras import Camera
from ..compose import combined, matches, untextured
from ..errors import SceneError
from ..files import read_file
from ..images.environment_maps import load_environment_map
from ..materials import Material
from ..scene import Environment, Scene
from .fields import Table, nearest
from .keyframes import load_track, with_clip_first
from .lights import load_light
from .medium import load_medium
from .models import file_path, load_model

TOP_KEYS = ("name", "exposure", "environment", "medium", "model", "material", "light", "camera", "keyframes",
            "animation")
MATERIAL_KEYS = ("name", "base_color", "alpha", "metallic", "roughness", "specular", "emissive", "normal_scale",
                 "alpha_mode", "alpha_cutoff", "double_sided", "textures")

_open_files: ContextVar[tuple[Path, ...]] = ContextVar("open_files", default=())
# Files that include each other twice, in a chain, are read twice as often with every link.
_MOST_FILES = 256
_read_files: ContextVar[list[Path] | None] = ContextVar("read_files", default=None)


def load_toml(path: str | Path) -> Scene:
    """Load a scene from a TOML file; docs/scenes.md lists its keys.

    Lights and cameras of the file come before those of its models. Raises SceneError: the file cannot be read, is not
    TOML, has unknown keys, values of the wrong type, length or range, names that nothing has, or includes itself.
    """
    path = Path(path)
    with _opened(path):
        top = Table(path, "", parsed(path))
        top.allow(TOP_KEYS)
        own = Scene(
            lights=[load_light(t, n) for n, t in enumerate(top.tables("light"), 1)],
            cameras=[_camera(t, n) for n, t in enumerate(top.tables("camera"), 1)],
            exposure=top.number("exposure", None, low=-50.0, high=50.0),
        )
        own.environment = _environment(top.table("environment"), own.warnings)
        medium = load_medium(top.table("medium"))
        keyframes, overrides = top.tables("keyframes"), top.tables("material")
        name = top.text("name", path.stem)
        scene = combined([own, *(load_model(t) for t in top.tables("model"))], name)
        if "environment" in top:
            scene.environment = own.environment
        scene.medium = medium
        for table in overrides:
            _override(table, scene)
        scene.tracks = with_clip_first(top.table("animation"), scene)
        scene.tracks += [load_track(t, scene) for t in keyframes]
        return scene


@contextmanager
def _opened(path: Path) -> Iterator[None]:
    """Raises SceneError when this file is being read already: it would include itself for ever."""
    real, above = path.resolve(), _open_files.get()
    if real in above:
        chain = " -> ".join(p.name for p in (*above[above.index(real):], real))
        raise SceneError(path, "[[model]]", f"the file includes itself: {chain}", "take one of these models out")
    read = (above and _read_files.get()) or []
    read.append(real)
    if len(read) > _MOST_FILES:
        raise SceneError(path, "", f"more than {_MOST_FILES} TOML files are read", "write the scene in fewer files")
    tokens = _open_files.set((*above, real)), _read_files.set(read)
    try:
        yield
    finally:
        _open_files.reset(tokens[0])
        _read_files.reset(tokens[1])


def parsed(path: Path) -> dict[str, Any]:
    """What a TOML file holds. Raises SceneError: cannot be read, is not TOML."""
    try:
        return tomllib.loads(read_file(path).decode("utf-8-sig"))  # some editors on Windows begin with a mark
    except OSError as error:
        raise SceneError(path, "", f"cannot be read: {error.strerror}", "check the name and the permissions") from error
    except tomllib.TOMLDecodeError as error:
        problem, _, place = str(error).partition(" (at ")
        remedy = "correct the line; toml.io shows how it is written"
        raise SceneError(path, place.rstrip(")"), f"is not TOML: {problem}", remedy) from error
    except UnicodeDecodeError as error:
        raise SceneError(path, "", "is not UTF-8 text", "save it as UTF-8") from error
    except RecursionError as error:
        raise SceneError(path, "", "lists or tables are nested too deeply", "write it flatter") from error
    except ValueError as error:  # an integer of thousands of digits
        raise SceneError(path, "", "holds a number that is too long to be read", "give it fewer digits") from error


def _environment(table: Table, warnings: list[str]) -> Environment:
    table.allow(("radiance", "image", "scale", "rotate"))
    radiance = table.color("radiance", (0.0, 0.0, 0.0))
    name = table.text("image", None)
    scale, degrees = table.number("scale", 1.0, low=0.0), table.number("rotate", 0.0)
    if name is None:
        for key in ("scale", "rotate"):
            if key in table:
                raise table.error(key, "stands without 'image'", "name an image, or leave it out")
        return Environment(radiance)
    path = file_path(table, "image", name)
    image = load_environment_map(path, scale, table.file, f"{table.place}: image", warnings)
    return Environment(radiance, image, radians(degrees))


def _camera(table: Table, number: int) -> Camera:
    table.allow(("name", "position", "look_at", "up", "vertical_fov", "near", "orthographic_height"))
    position, target = table.numbers("position", 3), table.numbers("look_at", 3)
    up = table.direction("up", (0.0, 1.0, 0.0))
    fov = table.number("vertical_fov", 45.0, above=0.0, below=180.0)
    near = table.number("near", 0.01, above=0.0)
    height = table.number("orthographic_height", None, above=0.0)
    try:
        return Camera.look_at(position, target, up, vertical_fov=radians(fov), near=near, orthographic_height=height,
                              name=table.text("name", f"camera {number}"))
    except ValueError as error:
        raise table.error("look_at", str(error), "move look_at, or turn up") from error


def _override(table: Table, scene: Scene) -> None:
    """Change the materials of the scene that one [[material]] table names."""
    table.allow(MATERIAL_KEYS)
    pattern = table.text("name")
    found = [n for n, material in enumerate(scene.materials) if matches(material.name, pattern)]
    if not found:
        names = [m.name for m in scene.materials if m.name]
        raise table.error("name", f"no material is named '{pattern}'", nearest(pattern, names))
    changes = _material_changes(table)
    keep_textures = table.boolean("textures", True)
    for n in found:
        material = replace(scene.materials[n], **changes)
        scene.materials[n] = material if keep_textures else untextured(material)


def _material_changes(table: Table) -> dict[str, Any]:
    """The fields of Material that the table sets."""
    m = Material()
    checked = {
        "base_color": table.color("base_color", m.base_color, high=1.0),
        "emissive": table.color("emissive", m.emissive),
        "normal_scale": table.number("normal_scale", m.normal_scale, low=0.0),
        "alpha_mode": table.choice("alpha_mode", ("opaque", "mask", "blend"), m.alpha_mode),
        "double_sided": table.boolean("double_sided", m.double_sided),
    }
    for key in ("alpha", "metallic", "roughness", "specular", "alpha_cutoff"):
        checked[key] = table.number(key, getattr(m, key), low=0.0, high=1.0)
    return {key: value for key, value in checked.items() if key in table}
