"""References from files: OpenEXR and NPZ as octolux writes them, and NPZ with a path tracer's arrays by light paths."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

from ..output.exr import shared_settings
from ..output.options import LAYERS, channel_names
from ..scene.errors import SceneError
from .reference import Reference

_NEEDED = ("radiance", "direct", "indirect", "depth")
_BY_PATHS = {"all_indirect": "full", "first_bounce": "one_bounce_total"}
"""Arrays of indirect light in a file by light paths, and of direct plus that."""

_RENDER = "Write all layers: octolux render SCENE --out reference.exr"


def read_reference(path: Path, paths: str = "") -> Reference:
    """The reference in `path`; `paths` chooses the indirect light of a file by light paths: all_indirect or
    first_bounce. Raises SceneError for a file that is missing, broken, lacks a layer or holds NaN or infinities."""
    if not path.is_file():
        raise SceneError(path, "", "no such file", "Check the reference's name")
    layers, about = _read_exr(path) if path.suffix.lower() == ".exr" else (_read_npz(path), {})
    layers = _with_means(layers)
    if any(name in layers for name in _BY_PATHS):
        return _by_light_paths(path, layers, paths or "all_indirect")
    if paths:
        raise SceneError(path, paths, "the file has one kind of indirect light only", f"Leave out ':{paths}'")
    _check(path, layers, _NEEDED, _RENDER)
    pictures = {"final": layers["radiance"], "indirect": layers["indirect"], "direct": layers["direct"]}
    halves = {name: (picture, picture) for name, picture in pictures.items()}
    mask = layers["depth"] > 0
    facts = {"file": str(path), **about}
    return Reference(path.name, pictures, halves, mask, False, facts, layers.get("position"))


def _with_means(layers: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The layers, with the mean of two halves where a file has only those."""
    means = {}
    for paths in _BY_PATHS:
        halves = [layers[name] for name in (f"seedA_{paths}", f"seedB_{paths}") if name in layers]
        if len(halves) == 2 and halves[0].shape == halves[1].shape:
            means[paths] = 0.5 * (halves[0] + halves[1])
    return means | layers


def _by_light_paths(path: Path, layers: dict[str, np.ndarray], paths: str) -> Reference:
    if paths not in _BY_PATHS:
        raise SceneError(path, paths, "there is no such light in the file", f"Choose {' or '.join(_BY_PATHS)}")
    seeds = [name for name in (f"seedA_{paths}", f"seedB_{paths}") if name in layers]
    _check(path, layers, ("direct", paths, "mask", *seeds), "Write direct and indirect light, and the mask")
    direct, indirect = layers["direct"], layers[paths]
    pictures = {"final": layers.get(_BY_PATHS[paths], direct + indirect), "indirect": indirect, "direct": direct}
    parts = [layers[name] for name in seeds] if len(seeds) == 2 else [indirect, indirect]
    final = [direct + part for part in parts] if len(seeds) == 2 else [pictures["final"]] * 2
    halves = {"final": (final[0], final[1]), "indirect": (parts[0], parts[1]), "direct": (direct, direct)}
    facts = {"file": str(path), "light_paths": paths}
    return Reference(
        f"{path.name}:{paths}", pictures, halves, layers["mask"] > 0, len(seeds) == 2, facts, layers.get("position")
    )


def _check(path: Path, layers: dict[str, np.ndarray], needed: tuple[str, ...], remedy: str) -> None:
    """Raise SceneError unless all the layers needed are there, of one size, and finite."""
    missing = [name for name in needed if name not in layers]
    if missing:
        raise SceneError(path, "", f"the layers {', '.join(missing)} are missing", remedy)
    for name in needed:
        size, first = layers[name].shape[:2], layers[needed[0]].shape[:2]
        if size != first or layers[name].shape[2:] != (() if name in ("depth", "mask") else (3,)):
            raise SceneError(path, name, f"the layer's shape is {layers[name].shape}, not that of the others", remedy)
        bad = int(np.count_nonzero(~np.isfinite(layers[name])))
        if bad:
            raise SceneError(path, name, f"{bad} values are NaN or infinite", "Render the reference anew")


def _read_exr(path: Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """The layers, and `frame_settings`, those that all techniques share, where the header has them."""
    try:
        file = OpenEXR.File(str(path), separate_channels=True)
        found, header = file.channels(), file.header()
        about = {"frame_settings": shared_settings(header)} if "frame_settings" in header else {}
    except (RuntimeError, OSError, ValueError) as error:
        raise _broken(path) from error
    channels = {name: np.asarray(channel.pixels, dtype=np.float32) for name, channel in found.items()}
    layers = {}
    for layer in LAYERS:
        names = channel_names(layer)
        if all(name in channels for name in names):
            parts = [channels[name] for name in names]
            layers[layer] = parts[0] if len(parts) == 1 else np.stack(parts, axis=-1)
    return layers, about


def _read_npz(path: Path) -> dict[str, np.ndarray]:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return {name: np.asarray(arrays[name], dtype=np.float32) for name in arrays.files}
    except (OSError, EOFError, TypeError, ValueError, zipfile.BadZipFile, zlib.error) as error:
        raise _broken(path) from error


def _broken(path: Path) -> SceneError:
    kind = "an OpenEXR" if path.suffix.lower() == ".exr" else "an NPZ"
    return SceneError(path, "", f"the file is not {kind} file, or it is damaged", "Write it again")
