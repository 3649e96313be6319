"""The command `octolux compare`."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from .. import cli_options as o
from .. import console

_COMPARED, _CHECK = "What is compared", "Files and checks"


def _option(group: str, metavar: str, help: str, *flags: str, **limits: Any) -> Any:
    return typer.Option(*flags, metavar=metavar, rich_help_panel=group, help=help, **limits)


_Techniques = Annotated[
    list[str],
    _option(
        _COMPARED, "NAME[:PRESET][,KEY=VALUE...]",
        "Such as uniform-lpv:paper,n=64; repeat for more. By default every technique but the reference.", "--technique",
    ),
]  # fmt: skip
_Reference = Annotated[
    str,
    _option(
        _COMPARED, "NAME|FILE",
        "A technique, in the same words, or an .exr or .npz with its layers; FILE.npz:first_bounce for other paths.",
    ),
]  # fmt: skip
_ReferenceSamples = Annotated[
    int | None, _option(_COMPARED, "N", "Samples a pixel of a reference that draws samples.", min=2)
]
_Size = Annotated[str | None, _option(_COMPARED, "WxH", "Pixels; by default the reference file's, else 640x360.")]
_Frames = Annotated[int, _option(_COMPARED, "N", "Frames to time for each technique.", min=1)]
_Out = Annotated[Path, _option(_CHECK, "DIR", "Folder for report.json and report.html.")]
_FailAbove = Annotated[
    list[str],
    _option(
        _CHECK, "[TECHNIQUE:][LAYER.]METRIC=VALUE",
        "Exit with 1 when a figure is above VALUE, such as flip=0.2 or uniform-lpv:indirect.relative_rmse=0.5.",
        "--fail-above",
    ),
]  # fmt: skip


def compare(
    scene: o.Scene,
    technique: _Techniques = [],  # noqa: B006
    reference: _Reference = "path-tracer",
    reference_samples: _ReferenceSamples = None,
    size: _Size = None,
    frames: _Frames = 5,
    out: _Out = Path("comparison"),
    fail_above: _FailAbove = [],  # noqa: B006
    camera: o.CameraName = None,
    exposure: o.Exposure = None,
    tone_map: o.ToneMap = "neutral",
    default_light: o.DefaultLight = True,
    sky_lights: o.SkyLights = 32,
    shadow_resolution: o.ShadowResolution = 1024,
    rsm_resolution: o.RsmResolution = 256,
    shadow_filter: o.ShadowFilter = 2,
    normal_maps: o.NormalMaps = True,
    inverse_square: o.InverseSquare = True,
    adapter: o.Adapter = None,
) -> None:
    """Render SCENE with several techniques and measure them against a reference."""
    from ..frame.settings import FrameSettings
    from ..gpu.device import Device
    from . import compare as compared
    from .choices import choices
    from .limits import check_labels, exceeded, limit
    from .report import check_folder

    limits = [limit(text) for text in fail_above]
    measured = choices(technique, reference)
    known = [name for one in measured for name in (one.label, one.technique)]
    check_labels(limits, [*dict.fromkeys(known), "constant", "black"])
    check_folder(out)
    pixels = o.size_of(size) if size else None
    report = compared(
        scene, technique, reference, size=pixels, camera=camera, exposure=exposure, tone_map=tone_map, frames=frames,
        reference_samples=reference_samples, default_light=default_light, device=Device(adapter),
        frame_settings=FrameSettings(
            shadow_resolution=shadow_resolution, rsm_resolution=rsm_resolution, sky_lights=sky_lights,
            shadow_filter=shadow_filter, normal_maps=normal_maps, inverse_square=inverse_square,
        ),
        command=shlex.join(["octolux", *sys.argv[1:]]), progress=lambda text: console.notes.print(text, markup=False),
    )  # fmt: skip
    for note in report.facts["notes"]:
        console.warn(note, "note")
    files = report.write(out)
    _print(report)
    console.out.print(f"wrote {' and '.join(map(str, files))}", markup=False, soft_wrap=True)
    phrases = exceeded(report, limits)
    if phrases:
        console.warn("; ".join(phrases), "above the limit")
        raise typer.Exit(1)


def _print(report: Any) -> None:
    from .report import figure

    table = Table(box=None)
    table.add_column("technique", overflow="fold")
    titles = ("frame\nms", "indirect\nenergy", "indirect\nRMSE", "final\nRMSE", "final\nFLIP", "final\nSSIM", "\nleak")
    for title in titles:
        table.add_column(title, justify="right", no_wrap=True)
    for entry in report.entries:
        indirect, final = entry.metrics["indirect"], entry.metrics["final"]
        values = (indirect["ratio"], indirect["relative_rmse"], final["relative_rmse"], final["flip"], final["ssim"],
                  entry.leak.score)  # fmt: skip
        table.add_row(entry.label, f"{entry.statistics['frame_ms']['median']:.1f}", *map(figure, values))
    console.out.print(table)
