"""OpenEXR: all layers as they are, float32, linear, in physical units."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

from ..frame.frame import TracedPaths
from ..frame.settings import FrameSettings
from ..picture import Picture
from .options import LAYERS, FileOptions, channel_names

_TRACED = ("radiance", "alpha", "direct", "indirect", "noise")
_WANTED = ("samples", "noise")  # settings that say how many paths there shall be


def write(picture: Picture, path: Path, options: FileOptions) -> None:
    """Write the layers of options.layers, with options.metadata in the header. Raises OSError."""
    channels = {name: np.ascontiguousarray(data) for name, data in _channels(picture, options).items()}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **options.metadata}
    header["exposure_ev100"] = float(picture.exposure or 0.0)
    if picture.paths:
        header |= {"paths": picture.paths, "relative_error": picture.relative_error}
    if options.wants("object_id"):
        names = {str(number): name for number, name in picture.object_names.items()}
        header["object_names"] = json.dumps(names, ensure_ascii=False)
    try:
        OpenEXR.File(header, channels).write(str(path))
    except RuntimeError as error:  # OpenEXR's name for a full disk and the like
        raise OSError(str(error)) from error


def _channels(picture: Picture, options: FileOptions) -> dict[str, np.ndarray]:
    channels: dict[str, np.ndarray] = {}
    for layer, data in picture.layers.items():
        if options.wants(layer):
            parts = [data] if data.ndim == 2 else np.moveaxis(data, -1, 0)
            channels.update(zip(channel_names(layer), parts, strict=True))
    return channels


def complete(path: Path, size: tuple[int, int], options: FileOptions) -> bool:
    """Whether `path` is a whole EXR of `size` (width, height) that holds every layer of the options."""
    try:
        file = OpenEXR.File(str(path), separate_channels=True)
        channels: dict[str, Any] = file.channels()
    except (RuntimeError, OSError, ValueError):  # OpenEXR reads all pixels, so that a cut file is among them
        return False
    header = file.header()
    if header.get("paths", 0) < options.paths and not header.get("relative_error", 1e30) <= options.noise:
        return False
    wanted = {name for layer in LAYERS if options.wants(layer) for name in channel_names(layer)}
    return wanted <= channels.keys() and all(channels[name].pixels.shape == size[::-1] for name in wanted)


def traced(path: Path, settings: dict[str, Any], shared: FrameSettings) -> TracedPaths | None:
    """The paths that are in a file which `write` made of a picture traced with such settings, to go on from; None where
    there is no such file, or where its settings differ in more than how many paths are wanted, or what paths depend on
    of those that all techniques share."""
    if not path.is_file():
        return None
    try:
        file = OpenEXR.File(str(path), separate_channels=True)
        channels, header = file.channels(), file.header()
        then, shared_then = json.loads(header["settings"]), shared_settings(header)
        layers = [np.stack([channels[name].pixels for name in channel_names(layer)], axis=-1) for layer in _TRACED]
    except (RuntimeError, OSError, ValueError, KeyError):
        return None
    if not header.get("paths") or any(then.get(key) != value for key, value in settings.items() if key not in _WANTED):
        return None
    if any(shared_then[name] != value for name, value in shared.of_paths.items()):
        return None
    return TracedPaths(int(header["paths"]), *layers)


def shared_settings(header: dict[str, Any]) -> dict[str, Any]:
    """The FrameSettings that a file's header tells of, and for what it does not, as in files of before there were
    any, the defaults. Raises ValueError for a header of other contents."""
    told = json.loads(header.get("frame_settings", "{}"))
    if not isinstance(told, dict):
        raise ValueError("frame_settings are no names with values")
    return {**vars(FrameSettings()), **told}
