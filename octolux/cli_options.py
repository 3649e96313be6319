"""The options of `octolux render` and `export`: what each is called, allows and means."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from .frame.anti_aliasing import MAX_SAMPLES, STILL_SAMPLES
from .output.options import LAYERS
from .scene import scene
from .scene.errors import OctoluxError
from .scene.materials import Color
from .scene.medium import Medium
from .scene.toml.fields import LARGEST
from .simulator.tonemap import TONE_MAPS

_LIGHT, _VIEW, _TIME, _FILES = "Light", "View and display", "Sequences", "Files"


def _option(group: str, metavar: str | None, help: str, *flags: str, **limits: Any) -> Any:
    return typer.Option(*flags, metavar=metavar, rich_help_panel=group, help=help, **limits)


Scene = Annotated[
    str, typer.Argument(metavar="SCENE", help="A model's file, a TOML scene, or what `octolux scenes` lists.")
]

Technique = Annotated[str, _option(_LIGHT, "NAME", "How indirect light is computed; `octolux techniques` lists them.")]
Preset = Annotated[str, _option(_LIGHT, "NAME", "The technique's preset.")]
Set = Annotated[list[str], _option(_LIGHT, "KEY=VALUE", "A setting of the technique; repeat for more.", "--set")]
Paths = Annotated[int | None, _option(_LIGHT, "N", "Paths through each pixel, of a technique that traces them.")]
Noise = Annotated[float | None, _option(_LIGHT, "X", "Stop tracing when the picture's relative error is below X.")]
DefaultLight = Annotated[bool, _option(_LIGHT, None, "Sun and sky for scenes in which nothing shines.")]
Fog = Annotated[
    str | None, _option(_LIGHT, "X|R,G,B", "Fog in the scene's box, in place of its medium: what it scatters, 1/m.")
]
FogAbsorption = Annotated[str | None, _option(_LIGHT, "X|R,G,B", "What this fog absorbs, 1/m; nothing by default.")]
FogResolution = Annotated[int, _option(_LIGHT, "1|2|4", "Fog is worked out for blocks of so many pixels.")]
SkyLights = Annotated[
    int, _option(_LIGHT, "N", "Distant lights that stand for the surroundings; 0: these light nothing.", min=0, max=200)
]
ShadowResolution = Annotated[int, _option(_LIGHT, "N", "Texels along a shadow map's edge.", min=16, max=8192)]
RsmResolution = Annotated[int, _option(_LIGHT, "N", "VPLs along the edge of a light's view.", min=8, max=4096)]
ShadowFilter = Annotated[
    int, _option(_LIGHT, "1|2", "Texels along the edge of the block that shadows' edges are blended over; 1: steps.")
]
NormalMaps = Annotated[bool, _option(_LIGHT, None, "Surfaces have the normal maps of their materials.")]
InverseSquare = Annotated[
    bool, _option(_LIGHT, None, "Point and spot lights fall off; else they bring everywhere what they do at 1 m.")
]
Adapter = Annotated[
    str | None, _option(_LIGHT, "NAME", "Part of a graphics adapter's name; `octolux devices` lists them.")
]

Size = Annotated[str, _option(_VIEW, "WxH", "Picture size in pixels.")]
CameraName = Annotated[str | None, _option(_VIEW, "NAME|INDEX", "The scene's camera; the first by default.")]
Exposure = Annotated[float | None, _option(_VIEW, "EV100", "By default the scene's, or metered at the first frame.")]
ToneMap = Annotated[str, _option(_VIEW, "NAME", f"One of {', '.join(TONE_MAPS)}.")]
AntiAliasing = Annotated[
    str,
    _option(
        _VIEW, "HOW",
        f"off, fxaa, a number of samples a pixel up to {MAX_SAMPLES}, or auto: {STILL_SAMPLES} samples for a still and "
        "for PNG with 16 bits or alpha, fxaa for other sequences.",
    ),
]  # fmt: skip

Frames = Annotated[
    str | None, _option(_TIME, "A..B|N", "Frames A to B, or N frames from 0 on; all light is made anew in each.")
]
Fps = Annotated[float, _option(_TIME, "N", "Frames a second; frame k shows the scene at k / fps.", min=0.001)]
Clip = Annotated[str | None, _option(_TIME, "NAME", "Which of the scene's animations; the first by default.")]
Resume = Annotated[bool, _option(_TIME, None, "Leave files that are complete as they are.", "--resume")]

Out = Annotated[
    list[Path],
    _option(
        _FILES, "FILE",
        ".png for display; .exr or .npz for all layers; .mp4, .webm, .gif. #### or {frame:04d} in the name is the "
        "frame's number; without it a picture is the last frame's. Repeatable; octolux.png by default.",
    ),
]  # fmt: skip
Bits = Annotated[int, _option(_FILES, "8|16", "Bits of a PNG's channels.")]
Alpha = Annotated[bool, _option(_FILES, None, "Leave the surroundings out: transparent in PNG.", "--alpha")]
Layers = Annotated[
    str | None, _option(_FILES, "A,B,...", f"Layers of .exr and .npz, of {', '.join(LAYERS)}; all by default.")
]
Debug = Annotated[
    list[str],
    _option(
        _FILES, "NAME=FILE",
        "What the technique's light cache holds after the last frame, as .png or .npz; `--debug list` says what there "
        "is. Repeatable.", "--debug",
    ),
]  # fmt: skip
Stats = Annotated[Path | None, _option(_FILES, "FILE", "Write times, memory and energy as JSON.")]

Exported = Annotated[Path, typer.Argument(metavar="OUT", help="An .xml file; what it names goes into OUT_files.")]
Time = Annotated[float, _option(_TIME, "SECONDS", "The scene as it is then.")]
Samples = Annotated[int, _option(_FILES, "N", "Samples a pixel that the file asks for.", min=1, max=2**24)]


def with_fog(scene: scene.Scene, scattering: str | None, absorption: str | None) -> scene.Scene:
    """The scene with the fog that --fog and --fog-absorption say, if they do. Raises OctoluxError."""
    if scattering is None and absorption is None:
        return scene
    given = {"--fog": scattering, "--fog-absorption": absorption}
    values = {flag: _coefficients(flag, text) for flag, text in given.items()}
    return replace(scene, medium=Medium(scattering=values["--fog"], absorption=values["--fog-absorption"]))


def _coefficients(flag: str, text: str | None) -> Color:
    """The color that `0.05` or `0.05,0.05,0.06` names; black for None. Raises OctoluxError."""
    try:
        numbers = [float(part) for part in ("0" if text is None else text).split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 3) or not all(0.0 <= number <= LARGEST for number in numbers):
        raise OctoluxError(f"{flag} is one number from 0 on, or three for red, green and blue, 1/m, not '{text}'.")
    red, green, blue = numbers if len(numbers) == 3 else numbers * 3
    return red, green, blue


def size_of(text: str) -> tuple[int, int]:
    """The (width, height) that `1280x720` names. Raises OctoluxError."""
    width, _, height = text.lower().partition("x")
    try:
        return int(width), int(height)
    except ValueError:
        raise OctoluxError(f"--size is WIDTHxHEIGHT in pixels, such as 1280x720, not '{text}'.") from None
