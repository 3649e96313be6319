"""cascaded-lpv's geometry volume with depth-peeled layers (CLPV 3.2, figure 11): what nobody sees blocks light too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import front_camera, read_buffer, scene_of, small_settings

from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box, quad
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.scene.scene import Scene
from octolux.techniques.lpv.cascaded.settings import CascadedLpvSettings
from octolux.techniques.settings import SettingsError

LAMPS = {
    "point": PointLight(position=(0.0, 0.0, 3.0), intensity=(5.0, 6.0, 7.0)),
    "spot": SpotLight(position=(0.0, 0.0, 3.0), direction=(0.0, 0.0, -1.0), intensity=(5.0, 6.0, 7.0), outer_angle=0.7),
    "sun": DirectionalLight(direction=(0.0, 0.0, -1.0), illuminance=(2.0, 2.0, 2.0)),
}
WALL = quad([(-2, -2, -2), (2, -2, -2), (2, 2, -2), (-2, 2, -2)])
BEFORE, BACKMOST = box((-0.6, -0.6, 0.6), (0.6, 0.6, 1.0)), box((-0.3, -0.3, -1.0), (0.3, 0.3, -0.6))
GREY = Material(base_color=(0.5, 0.4, 0.3), specular=0.0)


def scene(*lamps: str, hidden: bool = True) -> Scene:
    """A box, another behind it that neither lamps nor the camera see, and a wall."""
    meshes = [WALL, BEFORE, *([BACKMOST] if hidden else [])]
    return scene_of(meshes, [GREY], lights=[LAMPS[name] for name in lamps])


def rendered(device, of: Scene, preset: str = "default", **settings) -> Renderer:
    made = Renderer(
        of, "cascaded-lpv", preset=preset, size=(128, 96), device=device, exposure=0.0, settings={
            "n": 16, "cascades": 2, "bounces": 1, "glossy": False, "ambient_occlusion": False, **settings
        },
        default_light=False, profile=True, frame_settings=small_settings(
            shadow_resolution=128, rsm_resolution=128, sky_lights=0, emitter_lights=0
        ),
    )  # fmt: skip
    made.render(front_camera(3.0))
    return made


def behind(made: Renderer) -> np.ndarray:
    """Blocked shares of each cascade, cells whose middles are within half a cell of the hidden box: (cells, 3)."""
    low, high, found = BACKMOST.positions.min(axis=0), BACKMOST.positions.max(axis=0), []
    aside = 0.5 if made.technique.settings.propagation == "steps" else 0.0
    for grid, shares in zip(made.technique.cascades.grids, made.technique.debug_views()["blocked"], strict=False):
        places = grid.moved(aside).cell_centres()
        near = np.all((places > low - 0.5 * grid.cell_size) & (places < high + 0.5 * grid.cell_size), axis=-1)
        found.append(shares[near])
    return found


@pytest.mark.parametrize(("preset", "lamps"), [
    ("default", ["sun"]), ("paper", ["point"]), ("paper", ["spot"]), ("paper", []),
], ids=["sun", "point", "spot", "camera"])  # fmt: skip
def test_a_hidden_box_blocks_with_two_layers_alone(device, preset, lamps):
    """Its front of 60 x 60 cm across z, which is in the second layer: of the last cascade's cells, of 4 m / 14, as many
    walls as its area is. It is ten texels wide or more (128 over 7.2 m at most): at either rim one more or less."""
    surfels = "lamps" if lamps else "lamps and camera"
    one, two = (rendered(device, scene(*lamps), preset, surfels=surfels, layers=k) for k in (1, 2))
    assert not any(shares.any() for shares in behind(one)) and all(shares.any() for shares in behind(two)[1:])
    size = two.technique.cascades.grids[-1].cell_size
    across = behind(two)[-1][:, 2].sum() * size**2
    assert 0.36 * (1 - 2 / 10) ** 2 < across < 0.36 * (1 + 2 / 10) ** 2
    assert np.abs(behind(two)[-1][:, :2]).max() < 0.01  # sides that are seen by nobody


@pytest.mark.parametrize("preset", ["default", "paper"])
def test_layers_add_surfaces_and_leave_light(device, preset):
    """What blocks and reflects in one layer does with more, and others do besides, up to a wall; VPLs are of the
    first."""
    blocked, reflects, injected = [], [], []
    for layers in (1, 2):
        made = rendered(device, scene("sun"), preset, surfels="lamps", layers=layers, bounces=2)
        views, reflectors = made.technique.debug_views(), made.technique.way.reflectors.reflectors
        blocked.append(np.array(views["blocked"][:2]))
        reflects.append(np.count_nonzero(read_buffer(device, reflectors)))
        injected.append(views["injected"][1])
    one, two = blocked
    assert np.all(two >= one) and np.any(two > one) and two.max() <= 1.0 and one.any()
    assert reflects[1] > reflects[0] > 0
    if preset == "paper":  # gathering adds bounces to what is injected
        assert np.array_equal(*injected) and injected[0].any()


def test_more_layers_are_those_of_the_scene(device):
    """Sheets one behind the other: with as many layers as sheets the last has what the scene's surfels have of it, of
    128 texels in a row two less at the rims, or more."""
    sheets = [quad([(-1, -1, z), (1, -1, z), (1, 1, z), (-1, 1, z)]) for z in (0.75, 0.2, -0.35, -0.9)]
    of = scene_of(sheets, [GREY], lights=[LAMPS["sun"]])
    every = rendered(device, of, surfels="scene").technique.debug_views()["blocked"][1]
    for layers in range(1, 5):
        seen = rendered(device, of, surfels="lamps", layers=layers).technique.debug_views()["blocked"][1]
        filled = np.flatnonzero(every[..., 2].max(axis=(1, 2)) > 0.5)[::-1]
        shares = [seen[z, ..., 2].sum() / every[z, ..., 2].sum() for z in filled]
        assert len(filled) == 4 and not any(shares[layers:])
        np.testing.assert_allclose(shares[:layers], 1.0, atol=4 / 128)


def test_nothing_is_peeled_for_one_layer(device):
    made = rendered(device, scene("point"), "paper")
    assert not [name for name in made.profiler.last_frame() if name.startswith("peeled")]
    assert made._peeling is None


def test_frames_of_layers_are_repeatable(device):
    """Lamps come and go, and what is hidden moves: the picture is a fresh renderer's."""
    settings = {"preset": "paper", "layers": 3}
    made = rendered(device, scene("point", "sun"), **settings)
    for of in (scene("spot"), scene(hidden=False), replace(scene("sun", "spot"), materials=[Material()])):
        made.scene = of
        fresh = rendered(device, of, **settings).render(front_camera(3.0)).radiance
        assert np.array_equal(made.render(front_camera(3.0)).radiance, fresh)


@pytest.mark.parametrize(("changes", "says"), [
    ({"layers": 2}, "all layers already.*layers=1.*surfels=lamps"), ({"layers": 0, "surfels": "lamps"}, "1 to 4"),
    ({"layers": 5, "surfels": "lamps"}, "1 to 4"), *(
        ({**nothing, **asked, "surfels": "lamps"}, "nothing takes surfels.*occlusion=true, or layers=1 and keep")
        for nothing in ({"occlusion": False, "bounces": 1, "glossy": False},
                        {"occlusion": False, "bounces": 1, "propagation": "steps"})
        for asked in ({"layers": 2}, {"keep_surfels": True})
    ),
])  # fmt: skip
def test_layers_that_are_refused(changes, says):
    with pytest.raises(SettingsError, match=says):
        CascadedLpvSettings.make(**changes)


@pytest.mark.parametrize("changes", [
    {"bounces": 1, "glossy": False, "occlusion": True}, {"bounces": 2, "glossy": False}, {"bounces": 1, "glossy": True},
    {"propagation": "steps", "bounces": 1, "occlusion": True, "glossy": False},
], ids=["what blocks", "what reflects", "what is reflected", "what blocks steps"])  # fmt: skip
def test_layers_go_with(changes):
    asked = {"occlusion": False, "surfels": "lamps", "layers": 2, "keep_surfels": True, **changes}
    made = CascadedLpvSettings.make(**asked)
    assert {name: getattr(made, name) for name in asked} == asked
