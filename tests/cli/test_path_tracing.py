"""The path tracer from the program: how many paths, going on from an earlier file, stopping early."""

from __future__ import annotations

import numpy as np
import OpenEXR
import pytest

import octolux
from octolux.frame.settings import FrameSettings
from octolux.output import exr
from octolux.output.options import FileOptions
from octolux.sequence import Plan, Timeline, render_frames
from octolux.targets import Target

SIZE = (24, 24)


def renderer_of(device, samples: int, **settings) -> octolux.Renderer:
    values = {"samples": samples, **settings}
    return octolux.Renderer(octolux.load("cornell-box"), "path-tracer", settings=values, size=SIZE, device=device)


def make(renderer: octolux.Renderer, path, samples: int, resume: bool = True, noise: float = 0.0):
    plan = Plan((Target(path),), range(1), 24.0, SIZE, FileOptions(paths=samples, noise=noise), resume)
    return plan, render_frames(plan, Timeline(renderer, renderer.scene, 24.0)) if plan.missing else None


def layers_of(path) -> dict[str, np.ndarray]:
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return {name: channel.pixels for name, channel in channels.items()}


def test_a_file_of_fewer_paths_is_gone_on_with(device, tmp_path):
    """The first 8 paths and 8 more are the 16 of one run: the same paths, summed in float32."""
    path, whole = tmp_path / "a.exr", tmp_path / "b.exr"
    make(renderer_of(device, 8), path, 8)
    rounds = []
    renderer = renderer_of(device, 16)
    renderer.progress = lambda done, total: rounds.append((done, total)) is None
    _, made = make(renderer, path, 16)
    assert rounds[0] == (9, 16) and rounds[-1] == (16, 16)
    assert made.last.paths == 16 and OpenEXR.File(str(path)).header()["paths"] == 16
    make(renderer_of(device, 16), whole, 16)
    gone_on, at_once = layers_of(path), layers_of(whole)
    assert gone_on.keys() == at_once.keys()
    for name in ("R", "G", "B", "A", "direct.G", "indirect.G"):
        np.testing.assert_allclose(gone_on[name], at_once[name], rtol=1e-5, atol=1e-6, err_msg=name)
    # The standard error comes from a difference of squares: its rounding counts where it is small.
    np.testing.assert_allclose(gone_on["noise"], at_once["noise"], rtol=1e-2, atol=1e-3 * at_once["G"].mean())


def test_a_finished_file_is_left_alone(device, tmp_path):
    path = tmp_path / "a.exr"
    make(renderer_of(device, 4), path, 4)
    assert not make(renderer_of(device, 4), path, 4)[0].missing
    assert not make(renderer_of(device, 2), path, 2)[0].missing
    error = OpenEXR.File(str(path)).header()["relative_error"]
    assert not make(renderer_of(device, 64), path, 64, noise=1.01 * error)[0].missing
    assert make(renderer_of(device, 8), path, 8, resume=False)[0].missing


@pytest.mark.parametrize("change", [{"seed": 5}, {"paths": "indirect"}, {"bounces": 2}])
def test_paths_of_other_settings_are_not_mixed(device, tmp_path, change):
    path = tmp_path / "a.exr"
    make(renderer_of(device, 4), path, 4)
    assert exr.traced(path, renderer_of(device, 64).technique.settings.as_dict(), FrameSettings()).count == 4
    assert exr.traced(path, renderer_of(device, 64, **change).technique.settings.as_dict(), FrameSettings()) is None
    assert exr.traced(tmp_path / "none.exr", {}, FrameSettings()) is None


def test_paths_of_other_light_are_not_mixed(device, tmp_path):
    """Of what all techniques share only that counts which paths depend on; files of before tell nothing of it."""
    path, settings = tmp_path / "a.exr", renderer_of(device, 4).technique.settings.as_dict()
    make(renderer_of(device, 4), path, 4)
    assert exr.traced(path, settings, FrameSettings(shadow_filter=1, sky_lights=3)).count == 4
    for change in ({"normal_maps": False}, {"inverse_square": False}):
        assert exr.traced(path, settings, FrameSettings(**change)) is None
    file = OpenEXR.File(str(path), separate_channels=True)
    del file.header()["frame_settings"]
    file.write(str(path))
    assert exr.traced(path, settings, FrameSettings()).count == 4
    assert exr.traced(path, settings, FrameSettings(inverse_square=False)) is None


def test_ctrl_c_ends_a_picture_with_what_is_there(device, tmp_path):
    """A renderer that is told to stop gives the mean of the paths so far, which is written."""
    path = tmp_path / "a.exr"
    renderer = renderer_of(device, 1000)
    renderer.progress = lambda done, total: done < 3
    _, made = make(renderer, path, 1000)
    assert made.last.paths == 3 and OpenEXR.File(str(path)).header()["paths"] == 3
    three = renderer_of(device, 3).render()
    assert np.array_equal(made.last.radiance, three.radiance)
