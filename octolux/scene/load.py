"""One door for every source of scenes: names of built-in scenes, and files."""

from __future__ import annotations

import contextlib
import difflib
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .assimp import scene as assimp_scene
from .errors import SceneError
from .files import check_ordinary
from .geometry.extents import check_extent
from .gltf.loader import load_gltf
from .obj.loader import load_obj
from .scene import Scene


def load_scene(source: str | Path | Any) -> Scene:
    """The scene that `source` names: a built-in one, or a file by its extension (docs/scenes.md lists them).

    A built-in name wins over a file of that name; write ./NAME for the file. A trimesh.Trimesh or trimesh.Scene is
    converted as by `from_trimesh`. Raises SceneError.
    """
    from .builtin import BUILTIN  # imported here: building scenes needs much that loading a file does not

    if isinstance(source, str) and source in BUILTIN:
        return BUILTIN[source]()
    if not isinstance(source, str | os.PathLike):
        return _converted(source)
    path = Path(source)
    _check_readable(path, list(BUILTIN))
    loader = LOADERS.get(path.suffix.lower())
    if loader is None:
        raise _unknown_kind(path, list(BUILTIN))
    scene = loader(path)
    check_extent(scene, path)
    return scene


def _converted(source: Any) -> Scene:
    """An object of a library that this program has imported, or else it could not be one."""
    trimesh = sys.modules.get("trimesh")
    if trimesh is not None and isinstance(source, trimesh.Trimesh | trimesh.Scene):
        from .python.trimesh import from_trimesh

        return from_trimesh(source)
    remedy = "give a file, a built-in scene's name, or a trimesh.Trimesh or Scene"
    raise SceneError(type(source).__name__, "", "is nothing that a scene can be loaded from", remedy)


def _unknown_kind(path: Path, builtin: list[str]) -> SceneError:
    known = f"one of {', '.join(LOADERS)}, or a built-in scene: {', '.join(sorted(builtin))}"
    if not path.suffix:
        return SceneError(path, "", "the file name has no extension", f"give {known}")
    export = "export it as .glb, or " if path.suffix.lower() in _EXPORTABLE else ""
    return SceneError(path, "", f"files of the kind '{path.suffix}' are not read", f"{export}give {known}")


def _load_toml(path: Path) -> Scene:
    from .toml.loader import load_toml  # imported here: a TOML scene may itself include others through `load_scene`

    return load_toml(path)


LOADERS: dict[str, Callable[[Path], Scene]] = {
    ".obj": load_obj,
    ".gltf": load_gltf,
    ".glb": load_gltf,
    ".toml": _load_toml,
    **dict.fromkeys(assimp_scene.EXTENSIONS, assimp_scene.load_assimp),
}
_EXPORTABLE = (".blend", ".max", ".ma", ".mb", ".c4d", ".usd", ".usda", ".usdc", ".usdz", ".skp")
"""Files of programs that write glTF."""


def _check_readable(path: Path, builtin: list[str]) -> None:
    try:
        if path.is_dir():
            raise SceneError(path, "", "is a directory, not a scene", "name a file in it")
        check_ordinary(path)
        with path.open("rb"):
            return
    except FileNotFoundError as error:
        raise SceneError(path, "", "there is no such file or built-in scene", _suggestion(path, builtin)) from error
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise SceneError(path, "", f"cannot be read: {reason}", "check the name and the permissions") from error


def _suggestion(path: Path, builtin: list[str]) -> str:
    """The built-in name or the file beside `path` that is most like it, or what there is to choose from."""
    names = {name: name for name in builtin} if path.parent == Path() else {}
    with contextlib.suppress(OSError):  # no such folder, or one that may not be listed
        names |= {entry.name: str(entry) for entry in path.parent.iterdir() if entry.suffix.lower() in LOADERS}
    folded = {name.lower(): full for name, full in names.items()}
    close = difflib.get_close_matches(path.name.lower(), folded, n=1)
    if close:
        return f"perhaps '{folded[close[0]]}' is meant"
    return f"check the path, or give a built-in scene: {', '.join(sorted(builtin))}"
