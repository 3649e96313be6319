"""The program `octolux`."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import track
from rich.table import Table

from . import __version__
from .output import WRITERS, check_writable, write_json, write_picture
from .scene.errors import OctoluxError

app = typer.Typer(
    help="Real-time global illumination: render a scene, and see what each stage costs.",
    no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None,
)  # fmt: skip
_out = Console()
_notes = Console(stderr=True, highlight=False, soft_wrap=True)


def main() -> None:
    """Run the program; what the user can mend is one line on stderr and exit code 2."""
    try:
        app()
    except OctoluxError as error:
        _notes.print(f"error: {error}", markup=False)
        sys.exit(2)


def _version(wanted: bool) -> None:
    if wanted:
        _out.print(f"octolux {__version__}")
        raise typer.Exit


@app.callback()
def _program(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Real-time global illumination: render a scene, and see what each stage costs."""


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    try:
        return int(width), int(height)
    except ValueError:
        raise OctoluxError(f"--size is WIDTHxHEIGHT in pixels, such as 1280x720, not '{text}'.") from None


def _overrides(pairs: list[str]) -> dict[str, str]:
    bad = [pair for pair in pairs if "=" not in pair]
    if bad:
        raise OctoluxError(f"--set takes key=value, such as n=64, not '{bad[0]}'.")
    return {key.strip(): value.strip() for key, _, value in (pair.partition("=") for pair in pairs)}


@app.command()
def render(
    scene: Annotated[str, typer.Argument(help="A model (.obj .gltf .glb), a TOML scene, or a built-in scene's name.")],
    technique: Annotated[
        str, typer.Option(help="How indirect light is computed; `octolux techniques` lists them.")
    ] = "uniform-lpv",
    preset: Annotated[str, typer.Option(help="The technique's preset.")] = "default",
    set_: Annotated[
        list[str], typer.Option("--set", help="A setting of the technique, key=value; repeat for more.")
    ] = [],  # noqa: B006
    size: Annotated[str, typer.Option(help="Picture size in pixels, WIDTHxHEIGHT.")] = "1280x720",
    camera: Annotated[
        str | None, typer.Option(help="The scene's camera, by name or index; the first by default.")
    ] = None,
    exposure: Annotated[float | None, typer.Option(help="EV100; the scene's, or metered, by default.")] = None,
    frames: Annotated[
        int, typer.Option(min=1, help="Render so many frames, all light made anew in each; the last is written.")
    ] = 1,
    fps: Annotated[float, typer.Option(min=0.001, help="Frames a second, for scenes with keyframes.")] = 24.0,
    shadow_resolution: Annotated[
        int, typer.Option(min=16, max=8192, help="Texels along a shadow map's edge.")
    ] = 1024,
    rsm_resolution: Annotated[
        int, typer.Option(min=8, max=4096, help="VPLs along the edge of a light's view.")
    ] = 256,
    adapter: Annotated[
        str | None, typer.Option(help="Part of a graphics adapter's name; `octolux devices` lists them.")
    ] = None,
    out: Annotated[
        list[Path],
        typer.Option(help="Where to write: .png for display, .exr for all layers; repeatable; octolux.png by default."),
    ] = [],  # noqa: B006
    stats: Annotated[Path | None, typer.Option(help="Write times, memory and energy as JSON.")] = None,
) -> None:  # fmt: skip
    """Render SCENE and print what each stage cost."""
    targets = out or [Path("octolux.png")]
    _check_outputs(targets, stats)
    dimensions, overrides = _size(size), _overrides(set_)
    if not math.isfinite(fps):
        raise OctoluxError(f"--fps is a number of frames a second, not {fps}.")
    from .frame.frame import FrameSettings
    from .gpu.device import Device
    from .renderer import Renderer
    from .scene.load import load_scene
    from .techniques import technique_class

    settings = technique_class(technique).settings_class.from_strings(preset, overrides)
    loaded = load_scene(scene)
    renderer = Renderer(
        loaded, technique, settings=settings, size=dimensions, exposure=exposure, profile=True, device=Device(adapter),
        frame_settings=FrameSettings(shadow_resolution=shadow_resolution, rsm_resolution=rsm_resolution),
    )  # fmt: skip
    for note in [*loaded.warnings, *renderer.warnings]:
        _notes.print(f"warning: {note}", markup=False)
    picture = _frames(renderer, loaded, camera, frames, fps)
    _write(picture, {**renderer.statistics(), "energy": picture.energy}, targets, stats)


def _check_outputs(targets: list[Path], stats: Path | None) -> None:
    """Raise OctoluxError before any work is done when something could not be written after it."""
    for path in targets:
        check_writable(path, list(WRITERS))
    if stats:
        check_writable(stats, [".json"])


def _write(picture: Any, statistics: dict[str, Any], targets: list[Path], stats: Path | None) -> None:
    for path in targets:
        write_picture(picture, path)
        _out.print(f"wrote {path}", highlight=False)
    if stats:
        write_json(statistics, stats)
    _print_table(statistics)


def _frames(renderer: Any, scene: Any, camera: str | None, frames: int, fps: float) -> Any:
    picture = None
    numbers = range(frames)
    quiet = frames == 1 or not _notes.is_terminal
    for number in track(numbers, "rendering", console=_notes, transient=True, disable=quiet):
        renderer.scene = scene.at(number / fps) if scene.tracks else scene
        picture = renderer.render(camera)
    return picture


def _print_table(statistics: dict[str, Any]) -> None:
    from .gpu.memory import readable

    width, height = statistics["size"]
    frame = statistics["frame_ms"]
    title = f"{statistics['technique']}, {width}x{height}, {statistics['adapter']}"
    _out.print(title, highlight=False, markup=False, soft_wrap=True)
    table = Table()
    table.add_column("stage")
    for column in ("count", "mean ms", "median ms", "total ms"):
        table.add_column(column, justify="right")
    for row in statistics["stages"]:
        times = (f"{row[key]:.1f}" for key in ("mean_ms", "median_ms", "total_ms"))
        table.add_row(row["name"], str(row["count"]), *times)
    table.add_section()
    total = frame["mean"] * statistics["frames"]
    table.add_row("frame", str(statistics["frames"]), f"{frame['mean']:.1f}", f"{frame['median']:.1f}", f"{total:.1f}")
    _out.print(table, highlight=False)
    _out.print(f"memory on the device: {readable(statistics['memory_bytes']['total'])}", highlight=False)
    if statistics["frames"] == 1:
        _out.print("the first frame also builds the shaders; --frames 10 shows what a frame costs", highlight=False)
    if statistics["timing_note"]:
        _notes.print(f"note: {statistics['timing_note']}", markup=False)


@app.command()
def techniques() -> None:
    """List the techniques with their presets and settings."""
    import dataclasses

    from .techniques import TECHNIQUES
    from .techniques.settings import allowed_text

    for name, technique in TECHNIQUES.items():
        presets = ", ".join(["default", *technique.settings_class.PRESETS])
        _out.print(f"[bold]{name}[/]: {technique.summary}", highlight=False)
        _out.print(f"  presets: {presets}", highlight=False)
        for field in dataclasses.fields(technique.settings_class):
            about = field.metadata
            allowed = allowed_text(about["allowed"], about["unit"])
            line = f"  {field.name} = {field.default}: {about['meaning']} ({allowed})"
            _out.print(line, highlight=False, markup=False)
            _out.print(f"      cost: {about['cost']}; source: {about['source']}", highlight=False, markup=False)


@app.command()
def scenes() -> None:
    """List the built-in scenes."""
    from .scene.builtin import BUILTIN

    for name, make in BUILTIN.items():
        scene = make()
        cameras = ", ".join(c.name for c in scene.cameras)
        _out.print(f"{name}: {scene.triangle_count} triangles, cameras {cameras}", highlight=False)


@app.command()
def devices() -> None:
    """List the graphics adapters, best first."""
    from .gpu.device import Device, adapters

    found = adapters()
    if not found:
        Device()  # raises the error that says what to install
    for adapter in found:
        _out.print(adapter.summary, highlight=False)
