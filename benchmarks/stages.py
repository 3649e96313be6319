"""What each stage of a frame costs, by technique: frames of all take turns, so that the machine disturbs them alike.

Nothing moves: what a technique keeps as long as that is so is in none of these frames (clpv_table1.py makes it anew).
Maps of lights are drawn anew in each, as if lamps had moved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from octolux.compare.choices import choice
from octolux.renderer import Renderer
from octolux.scene.scene import Scene

from .comparison_set import TECHNIQUES, VIEWS, scene_of
from .lab import device, interleaved
from .registry import at_most, figure

SIZE, FRAMES, WARM_UP = (1280, 720), 7, 2
SMALL = (320, 180)
KEEPING = ("cascaded-lpv", "voxel-cones")


def interleaved_stages(
    scene: Scene, camera: str, techniques: Sequence[str], size: tuple[int, int], frames: int
) -> dict[str, dict[str, float]]:
    """Median ms of every stage, and of the whole `frame`, by technique."""
    made = {}
    for text in techniques:
        one = choice(text)
        made[text] = Renderer(scene, one.technique, settings=one.settings, size=size, device=device(), profile=True)
    for number in range(WARM_UP + frames):
        for renderer in made.values():
            if number == WARM_UP:
                renderer.profiler.clear()
            renderer.forget()
            renderer.render(camera)
    found = {}
    for text, renderer in made.items():
        found[text] = {row["name"]: row["median_ms"] for row in renderer.profiler.stages()}
        found[text]["frame"] = renderer.profiler.frame_ms()["median"]
    return found


def _stages(name: str) -> dict[str, float]:
    view = VIEWS[name]
    found = interleaved_stages(scene_of(view), view.camera, ("none", *TECHNIQUES), SIZE, FRAMES)
    return {
        f"{text}.{stage.replace(' ', '_')}": time for text, stages in found.items() for stage, time in stages.items()
    }


@figure("stages_atrium", group="stages", unit="ms")
def stages_atrium() -> dict[str, float]:
    """Stages of a frame of the atrium at 1280x720 by technique: medians of frames that take turns."""
    return _stages("atrium")


@figure("stages_crytek_lamps", group="stages", unit="ms")
def stages_crytek_lamps() -> dict[str, float]:
    """The same for Crytek Sponza under three point lights, each with six views of RSMs."""
    return _stages("crytek_lamps")


@figure("kept_maps", group="stages", unit="x", bound={text: at_most(1.0) for text in KEEPING})
def kept_maps() -> dict[str, float]:
    """Crytek Sponza under three point lights at 320x180, in which nothing moves: a frame that keeps shadow maps and
    RSMs over one that draws them anew, median of frames that take turns."""
    view, found = VIEWS["crytek_lamps"], {}
    for text in KEEPING:
        one = choice(text)
        renderer = Renderer(
            scene_of(view), one.technique, settings=one.settings, size=SMALL, exposure=0.0, device=device()
        )
        found[text] = interleaved(*_kept_and_anew(renderer, view.camera), FRAMES)["ratio"]
    return found


def _kept_and_anew(renderer: Renderer, camera: str) -> tuple[Callable[[], None], Callable[[], None]]:
    """A frame after another, and one as if lights had moved."""

    def kept() -> None:
        renderer.render(camera)

    def anew() -> None:
        renderer.forget()
        renderer.render(camera)

    return kept, anew
