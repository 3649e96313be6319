"""The program `octolux`."""

from __future__ import annotations

import json
import math
import sys
import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import __version__, cli_options, console
from .compare.command import compare
from .output import check_writable, write_json
from .output.debug import check_views, debug_files, write_views
from .output.options import FileOptions, layer_names
from .scene.errors import OctoluxError, one_line
from .simulate import simulate
from .targets import Target, frame_range

if TYPE_CHECKING:
    from .renderer import Renderer
    from .scene.scene import Scene
    from .sequence import Plan, Timeline
    from .techniques.settings import Settings

app = typer.Typer(
    help="Real-time global illumination: render a scene, and see what each stage costs.",
    no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None,
)  # fmt: skip
_WIDEST = 2000  # characters of a line of `info`
_LIST = ["list"]  # what --debug is given to say what there is
_INTERRUPTED = 130  # 128 + SIGINT, as shells have it


def main() -> None:
    """Run the program; what the user can mend is one line on stderr and exit code 2."""
    warnings.filterwarnings("ignore", module=r"PIL\.")  # of pictures that are too large or odd: octolux says so itself
    try:
        app()
    except OctoluxError as error:
        console.warn(str(error), "error")
        sys.exit(2)
    except SystemExit as stop:
        if stop.code == _INTERRUPTED:
            console.notes.print("stopped; --resume renders what is missing")
        raise


def _version(wanted: bool) -> None:
    if wanted:
        console.out.print(f"octolux {__version__}")
        raise typer.Exit


@app.callback()
def _program(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Real-time global illumination: render a scene, and see what each stage costs."""


def _overrides(pairs: list[str]) -> dict[str, str]:
    bad = [pair for pair in pairs if "=" not in pair]
    if bad:
        raise OctoluxError(f"--set takes key=value, such as n=64, not '{bad[0]}'.")
    return {key.strip(): value.strip() for key, _, value in (pair.partition("=") for pair in pairs)}


@app.command(cls=console.GroupedCommand)
def render(
    scene: cli_options.Scene,
    technique: cli_options.Technique = "octree-lpv",
    preset: cli_options.Preset = "default",
    set_: cli_options.Set = [],  # noqa: B006
    samples: cli_options.Paths = None,
    noise: cli_options.Noise = None,
    default_light: cli_options.DefaultLight = True,
    fog: cli_options.Fog = None,
    fog_absorption: cli_options.FogAbsorption = None,
    fog_resolution: cli_options.FogResolution = 2,
    sky_lights: cli_options.SkyLights = 32,
    shadow_resolution: cli_options.ShadowResolution = 1024,
    rsm_resolution: cli_options.RsmResolution = 256,
    shadow_filter: cli_options.ShadowFilter = 2,
    normal_maps: cli_options.NormalMaps = True,
    inverse_square: cli_options.InverseSquare = True,
    adapter: cli_options.Adapter = None,
    size: cli_options.Size = "1280x720",
    camera: cli_options.CameraName = None,
    exposure: cli_options.Exposure = None,
    tone_map: cli_options.ToneMap = "neutral",
    anti_aliasing: cli_options.AntiAliasing = "auto",
    frames: cli_options.Frames = None,
    fps: cli_options.Fps = 24.0,
    clip: cli_options.Clip = None,
    resume: cli_options.Resume = False,
    out: cli_options.Out = [],  # noqa: B006
    bits: cli_options.Bits = 8,
    alpha: cli_options.Alpha = False,
    layers: cli_options.Layers = None,
    debug: cli_options.Debug = [],  # noqa: B006
    stats: cli_options.Stats = None,
) -> None:
    """Render SCENE and print what each stage cost."""
    settings = _settings(technique, preset, set_, samples=samples, noise=noise)
    plan = _plan(out, frames, fps, size, _file_options(bits, alpha, layers, settings), resume)
    if stats:
        check_writable(stats, [".json"])
    files = [] if debug == _LIST else debug_files(debug, resume)
    from .scene.load import load_scene
    from .sequence import Timeline

    loaded = cli_options.with_fog(load_scene(scene), fog, fog_absorption)
    plan.remove_leftovers()
    if _nothing_to_do(plan):
        return
    of_frames = {"shadow_resolution": shadow_resolution, "rsm_resolution": rsm_resolution, "sky_lights": sky_lights,
                 "fog_resolution": fog_resolution, "shadow_filter": shadow_filter, "normal_maps": normal_maps,
                 "inverse_square": inverse_square}  # fmt: skip
    renderer = _renderer(
        loaded, adapter, of_frames, technique=technique, settings=settings, size=plan.size, exposure=exposure,
        anti_aliasing=anti_aliasing, sequence=plan.filtered, tone_map=tone_map, transparent=alpha,
        default_light=default_light,
    )  # fmt: skip
    if debug == _LIST:
        _say(renderer.technique.debug_views().lines() or ["this technique has no debug views"])
        return
    timeline = Timeline(renderer, loaded, fps, first=plan.frames[0], camera=camera, clip=clip)
    _make_with_views(plan, timeline, stats, files)


def _nothing_to_do(plan: Plan) -> bool:
    """Whether all files are complete, which is then said."""
    complete = not plan.missing and not plan.videos
    if complete:
        console.out.print("nothing to do: all files are complete")
    return complete


def _make_with_views(plan: Plan, timeline: Timeline, stats: Path | None, files: list[tuple[str, Path]]) -> None:
    """Make all pictures, and of the last frame the debug views."""
    technique = timeline.renderer.technique
    check_views(technique.debug_views(), files)
    _make(plan, timeline, stats)
    _say(f"wrote {path}" for path in write_views(technique.debug_views(), files))


def _file_options(bits: int, alpha: bool, layers: str | None, settings: Settings) -> FileOptions:
    paths, noise = getattr(settings, "samples", 0), getattr(settings, "noise", 0.0)
    return FileOptions(bits, alpha, layer_names(layers), paths=paths, noise=noise)


def _say(lines: Iterable[str]) -> None:
    for line in lines:
        console.out.print(line, markup=False, soft_wrap=True)


def _settings(technique: str, preset: str, pairs: list[str], **given: float | None) -> Settings:
    """A technique's settings: a preset, what --set says of it, and what options of their own do."""
    from .techniques import technique_class

    overrides = {**_overrides(pairs), **{key: str(value) for key, value in given.items() if value is not None}}
    return technique_class(technique).settings_class.from_strings(preset, overrides)


def _renderer(scene: Scene, adapter: str | None, frame: dict[str, Any], **options: Any) -> Renderer:
    """A renderer that times its stages, `frame` being its FrameSettings; says what the scene lacks."""
    from .frame.settings import FrameSettings
    from .gpu.device import Device
    from .renderer import Renderer

    renderer = Renderer(scene, profile=True, device=Device(adapter), frame_settings=FrameSettings(**frame), **options)
    for note in [*scene.warnings, *renderer.warnings]:
        console.warn(note)
    return renderer


def _plan(out: list[Path], frames: str | None, fps: float, size: str, options: FileOptions, resume: bool) -> Plan:
    from .sequence import Plan

    if not math.isfinite(fps):
        raise OctoluxError(f"--fps is a number of frames a second, not {fps}.")
    targets = tuple(map(Target, out or [Path("octolux.png")]))
    return Plan(targets, frame_range(frames or "1"), fps, cli_options.size_of(size), options, resume)


def _make(plan: Plan, timeline: Timeline, stats: Path | None) -> None:
    """Render what is missing, write it, and say what was done."""
    from .sequence import render_frames

    with console.rounds() as timeline.renderer.progress:
        made = render_frames(plan, timeline, console.track)
    for line in made.summary(plan):
        console.out.print(line, markup=False, soft_wrap=True)
    if made.interrupted:
        raise typer.Exit(_INTERRUPTED)
    if made.last is None:
        return
    statistics = {**timeline.renderer.statistics(), "energy": made.last.energy}
    if stats:
        write_json(statistics, stats)
    console.print_statistics(statistics)


app.command(cls=console.GroupedCommand)(compare)
app.command()(simulate)


@app.command()
def techniques(
    as_json: Annotated[bool, typer.Option("--json", help="Print them as JSON.")] = False,
) -> None:
    """List the techniques with their presets and settings."""
    from . import listing

    if as_json:
        typer.echo(json.dumps(listing.techniques(), indent=1))
        return
    for line in listing.technique_lines():
        console.out.print(line, markup=False, soft_wrap=True, style="bold" if line[0] != " " else "")


@app.command()
def scenes() -> None:
    """List the built-in scenes."""
    from . import listing

    for line in listing.scene_lines():
        console.out.print(line, markup=False, soft_wrap=True)


@app.command()
def info(
    scene: Annotated[str, typer.Argument(help="A model, a TOML scene, or a built-in scene's name.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print it as JSON.")] = False,
) -> None:
    """Say what SCENE holds, and what is missing or guessed."""
    from .info import info_lines, scene_facts

    facts = scene_facts(scene)
    lines = [json.dumps(facts, indent=1)] if as_json else [one_line(line, _WIDEST) for line in info_lines(facts)]
    typer.echo("\n".join(lines))


@app.command(cls=console.GroupedCommand)
def export(
    scene: cli_options.Scene,
    out: cli_options.Exported,
    size: cli_options.Size = "1280x720",
    camera: cli_options.CameraName = None,
    time: cli_options.Time = 0.0,
    clip: cli_options.Clip = None,
    default_light: cli_options.DefaultLight = True,
    samples: cli_options.Samples = 64,
) -> None:
    """Write SCENE for Mitsuba 3: OUT.xml, and meshes and pictures beside it."""
    from .export.command import export_scene

    for note in export_scene(scene, out, camera, cli_options.size_of(size), time, clip, default_light, samples):
        console.warn(note)
    console.out.print(f"wrote {out}", markup=False, soft_wrap=True)


@app.command()
def devices() -> None:
    """List the graphics adapters, best first."""
    from .gpu.device import Device, adapters

    found = adapters()
    if not found:
        Device()  # raises the error that says what to install
    for adapter in found:
        console.out.print(adapter.summary, markup=False, soft_wrap=True)
