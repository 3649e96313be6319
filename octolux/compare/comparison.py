"""The comparison: render all, measure all against the reference."""

from __future__ import annotations

import platform
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import __version__
from ..frame.settings import FrameSettings
from ..gpu.device import Device
from ..scene.errors import OctoluxError, SceneError
from ..scene.load import load_scene
from ..scene.scene import Scene
from .choices import Choice, choice, choices, reference_file
from .metrics import Leak, leak, relative_errors
from .perception import SSIM_WINDOW, flip, flip_missing, ssim
from .reference import COMPARED, Reference
from .reference_files import read_reference
from .rendering import Rendering, Studio, black, fitted_constant
from .report import Entry, Report

DEFAULT_SIZE = (640, 360)
"""Pixels: a quarter of 1280 x 720, as a reference takes long."""

_SAME_PLACE = 0.01
"""Of the extent of what is seen: a reference whose surfaces are farther off in half of the pixels has another view."""


def compare(
    scene: Scene | str | Path, techniques: Sequence[str] = (), reference: str | Path = "path-tracer", *,
    size: tuple[int, int] | None = None, camera: str | int | None = None, exposure: float | None = None,
    tone_map: str = "neutral", frames: int = 5, reference_samples: int | None = None, default_light: bool = True,
    frame_settings: FrameSettings | None = None, device: Device | None = None, command: str = "",
    progress: Callable[[str], None] = lambda text: None,
) -> Report:  # fmt: skip
    """Render `scene` with all `techniques` from the same view, and measure them against `reference`.

    techniques: texts such as "uniform-lpv:paper,n=64"; without any, all that there are.
    reference: a technique in the same words, or an EXR or NPZ file; "FILE.npz:first_bounce" takes other light paths.
    size: (width, height), pixels; by default the file's, or DEFAULT_SIZE.  frames: timed for each technique.
    reference_samples: a pixel.  command: how to do it again, for the report.  progress: is told what is being done.
    The rest is as in Renderer. `constant`, fitted to the reference, and `black` are compared as well.

    Raises OctoluxError for unknown techniques, cameras or settings, and for a file that does not fit.
    """
    file = reference_file(reference)
    measured = choices(list(techniques), "" if file else str(reference).partition(":")[0].partition(",")[0])
    wanted = None if file else choice(str(reference), as_reference=True)
    known = read_reference(*file) if file else None
    if frames < 1:
        raise OctoluxError(f"At least one frame is timed, not {frames}.")
    if known and reference_samples is not None:
        raise OctoluxError("--reference-samples is for a reference that is rendered, not for a file. Leave it out.")
    loaded = scene if isinstance(scene, Scene) else load_scene(scene)
    if loaded.tracks:
        loaded = loaded.at(0.0)
    studio = Studio(
        loaded, device or Device(), _size(size, known, file), camera, exposure, tone_map, default_light,
        frame_settings, frames, progress,
    )  # fmt: skip
    progress("direct light")
    studio.settle_exposure(next((c for c in measured if not c.seeded), black()))
    dark, level = studio.direct_light()
    if known is None and wanted is not None:
        progress(f"reference {wanted.label}")
        known = studio.reference(wanted, reference_samples)
    assert known is not None
    notes = _check_view(known, dark)
    if file:
        notes += _other_settings(known, studio.frame_settings or FrameSettings())
    mask = known.mask & dark.mask
    entries = []
    for one in (*measured, fitted_constant(known, dark.albedo, mask), black()):
        progress(one.label)
        rendering = dark if one.label == "black" else studio.render(one)
        entries.append(_entry(one, rendering, known, mask, level, studio))
    return Report(_facts(scene, loaded, studio, known, mask, level, command, notes), entries, known, studio.displayed)


def _size(wanted: tuple[int, int] | None, known: Reference | None, file: tuple[Path, str] | None) -> tuple[int, int]:
    """Raises OctoluxError where the reference's is another, or SSIM's window does not fit."""
    size = wanted or (known.size if known else DEFAULT_SIZE)
    if known and file and size != known.size:
        width, height = known.size
        raise SceneError(
            file[0], "", f"the reference is {width}x{height} pixels, not {size[0]}x{size[1]} as --size says",
            f"Use --size {width}x{height}, or leave it out",
        )  # fmt: skip
    if min(size) < SSIM_WINDOW:
        raise OctoluxError(f"Pictures to compare are at least {SSIM_WINDOW}x{SSIM_WINDOW} pixels, not {size}.")
    return size


def _check_view(known: Reference, ours: Rendering) -> list[str]:
    """What is odd about a reference from elsewhere. Raises OctoluxError where both see nothing in common."""
    both = known.mask & ours.mask
    if not both.any():
        raise OctoluxError(f"{known.name}: no pixel shows a surface both there and in the scene. Is it of this view?")
    if known.position is None:
        return []
    places = ours.position[both].astype(np.float64)
    extent = float(np.linalg.norm(np.ptp(places, axis=0)))
    apart = float(np.median(np.linalg.norm(known.position[both] - places, axis=-1)))
    if apart > _SAME_PLACE * extent:
        return [f"the reference shows other places: half of the surfaces are more than {apart:.3g} m off; see --camera"]
    return []


def _other_settings(known: Reference, settings: FrameSettings) -> list[str]:
    """What a reference's file is made with that techniques are not; where it does not tell, the defaults."""
    made = {**FrameSettings().of_paths, **known.facts.get("frame_settings", {})}
    others = [(name, value) for name, value in settings.of_paths.items() if made[name] != value]
    return [f"the reference is made with {name}={made[name]}, the techniques with {value}" for name, value in others]


def _entry(
    one: Choice, rendering: Rendering, known: Reference, mask: np.ndarray, level: float | None, studio: Studio
) -> Entry:
    metrics: dict[str, Any] = {}
    flips = {}
    for layer in COMPARED:
        errors = relative_errors(rendering.pictures[layer], *known.halves[layer], mask, known.pictures[layer])
        shown = studio.displayed(rendering.pictures[layer]), studio.displayed(known.pictures[layer])
        found = flip(*shown)
        flips[layer] = found[1] if found else None
        metrics[layer] = {
            "ratio": errors["ratio"], "relative_rmse": errors["rmse"], "trimmed_relative_rmse": errors["trimmed"],
            "flip": found[0] if found else None, "ssim": ssim(*shown),
        }  # fmt: skip
    light = rendering.pictures["direct"] + rendering.pictures["indirect"]
    halves = [known.halves["direct"][k] + known.halves["indirect"][k] for k in (0, 1)]
    leaks = leak(light, halves[0], halves[1], mask, level) if level else Leak(None, None, 0.0)
    return Entry(one, metrics, leaks, rendering.pictures, mask, flips, rendering.statistics)


def _facts(
    source: Scene | str | Path, scene: Scene, studio: Studio, known: Reference, mask: np.ndarray,
    level: float | None, command: str, notes: list[str],
) -> dict[str, Any]:  # fmt: skip
    settings = replace(studio.frame_settings or FrameSettings(), width=studio.size[0], height=studio.size[1])
    air = ["the scene has a medium: references by path tracing have clear air"] if scene.medium else []
    missing = [f"no FLIP: {flip_missing()}"] if flip_missing() else []
    return {
        "octolux": __version__,
        "command": command,
        "scene": scene.name if isinstance(source, Scene) else str(source),
        "triangles": scene.triangle_count,
        "camera": _camera_name(scene, studio.camera),
        "size": list(studio.size),
        "exposure_ev100": studio.exposure,
        "tone_map": studio.tone_map,
        "default_light": studio.default_light,
        "frame_settings": vars(settings),
        "adapter": studio.device.adapter_name,
        "machine": {"system": platform.platform(), "processor": platform.processor() or platform.machine()},
        "versions": _versions(),
        "reference": {
            "name": known.name, **known.facts, "noise_free": known.noise_free,
            "noise": {layer: known.noise(layer) for layer in COMPARED},
        },
        "compared_pixels": int(mask.sum()),
        "lit_level_nits": level,
        "notes": [*notes, *missing, *air],
    }  # fmt: skip


def _camera_name(scene: Scene, camera: str | int | None) -> str:
    names = [c.name or str(number) for number, c in enumerate(scene.cameras)]
    if not names or camera in names:
        return str(camera or "default")
    return names[int(camera or 0)]


def _versions() -> dict[str, str]:
    from importlib.metadata import PackageNotFoundError, version

    found = {"python": platform.python_version()}
    for package in ("numpy", "wgpu", "flip-evaluator"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found
