"""cascaded-lpv with surfels of static geometry kept from earlier frames (CLPV 3.2): the volume fills as the camera
looks around, and forgets what moved."""

from __future__ import annotations

import gc
from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import read_buffer, scene_of, small_settings

from octolux.gpu_scene.history import MOVING_SYNCS
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box
from octolux.scene.cameras import Camera
from octolux.scene.lights import SpotLight
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.simulator.lpv.keeping import forgotten_cells
from octolux.techniques.lpv.cascaded.settings import CascadedLpvSettings
from octolux.techniques.settings import SettingsError

ROOM = box((-2, -2, -2), (2, 2, 2), inward=True)
BLOCK = box((-0.3,) * 3, (0.3,) * 3, material=1)
LAMP = SpotLight(position=(0.0, 1.9, 0.0), direction=(0.0, -1.0, 0.0), intensity=(5.0, 6.0, 7.0), outer_angle=0.2)
MATERIALS = [Material(base_color=(0.5, 0.4, 0.3), specular=0.0), Material(base_color=(0.2, 0.7, 0.3), specular=0.0)]
WAYS = ["default", "paper"]
PLACE = (1.2, 0.0, 0.0)


def scene(*places: tuple[float, float, float], materials=MATERIALS) -> Scene:
    """Blocks in a room; the lamp lights a spot of its floor."""
    moves = [np.eye(4) for _ in places]
    for move, place in zip(moves, places, strict=True):
        move[:3, 3] = place
    return scene_of([ROOM, BLOCK], list(materials), lights=[LAMP],
                    instances=[Instance(0), *(Instance(1, transform=move) for move in moves)])  # fmt: skip


def towards(x: float, z: float = 0.0) -> Camera:
    return Camera.look_at((0.0, 0.0, 0.0), (x, 0.0, z), vertical_fov=1.3)


RIGHT, LEFT = towards(1.0), towards(-1.0)


def renderer(device, of: Scene, preset: str, **settings) -> Renderer:
    settings = {
        "n": 16, "cascades": 2, "surfels": "lamps and camera", "keep_surfels": True, "bounces": 1, "glossy": False,
        "ambient_occlusion": False, **settings,
    }  # fmt: skip
    return Renderer(
        of, "cascaded-lpv", preset=preset, settings=settings, size=(48, 48), device=device, exposure=0.0,
        default_light=False, frame_settings=small_settings(sky_lights=0, emitter_lights=0),
    )  # fmt: skip


def blocked(made: Renderer) -> np.ndarray:
    """Shares [window][z][y][x][3]."""
    return np.array(made.technique.debug_views()["blocked"][:2])


def around(made: Renderer, place) -> np.ndarray:
    """Bool [window][z][y][x]: cells in which a block at `place` lies, or beside which it does."""
    aside = 0.5 if made.technique.settings.propagation == "steps" else 0.0
    low = np.array([place]) - 0.3
    return np.array([forgotten_cells(grid.moved(aside), low, low + 0.6) for grid in made.technique.cascades.grids])


def shown(made: Renderer, *cameras: Camera) -> np.ndarray:
    for camera in cameras:
        made.render(camera)
    return blocked(made)


@pytest.mark.parametrize("preset", WAYS)
def test_what_has_been_seen_stays(device, preset):
    """Of the cascade that does not move. Without keeping it goes when the camera turns; and it is the most of all that
    cameras have seen, whichever was first."""
    kept, new = renderer(device, scene(PLACE), preset), renderer(device, scene(PLACE), preset, keep_surfels=False)
    first, then = (shown(new, camera)[1] for camera in (RIGHT, LEFT))
    assert np.array_equal(shown(kept, RIGHT)[1], first)
    assert np.array_equal(shown(kept, LEFT)[1], np.maximum(first, then))
    assert np.array_equal(shown(kept, RIGHT)[1], np.maximum(first, then))
    here = around(kept, PLACE)[1]
    assert first[here].any() and not then[here].any() and (first > then).sum() > 100


@pytest.mark.parametrize("preset", WAYS)
def test_what_has_been_seen_reflects(device, preset):
    """With bounces: the block in its green, though it is behind the camera."""
    kept = renderer(device, scene(PLACE), preset, bounces=2, cascades=1)
    seen = {}
    for name, camera in (("right", RIGHT), ("left", LEFT)):
        kept.render(camera)
        seen[name] = read_buffer(device, kept.technique.way.reflectors.reflectors).reshape(-1, 3, 4)[:4096]
    filled = np.flatnonzero(seen["right"][:, :2].any(axis=(1, 2)))
    assert len(filled) > 50 and np.all(seen["left"][filled, :2] >= seen["right"][filled, :2])
    here = around(kept, PLACE)[0].ravel()
    green = seen["left"][:, 2, 1] > 2.0 * seen["left"][:, 2, 0]
    assert np.count_nonzero(green & here) > 5 and not np.any(green & ~here)


@pytest.mark.parametrize("preset", WAYS)
def test_windows_that_move_keep_the_world(device, preset):
    """The finest window follows the camera: what stays in it stays as it was, to the bit, or more of it is seen."""
    made = renderer(device, scene(PLACE), preset)
    before, grid = shown(made, RIGHT)[0], made.technique.cascades.grids[0]
    ahead = Camera.look_at((0.0, 0.0, 0.6), (0.0, 0.0, 5.0), vertical_fov=0.2)
    after, now = shown(made, ahead)[0], made.technique.cascades.grids[0]
    shift = np.rint(np.subtract(now.origin, grid.origin) / grid.cell_size).astype(int)
    assert shift.any()
    only_here = renderer(device, scene(PLACE), preset)
    seen = shown(only_here, ahead)[0]
    there = np.argwhere((before > 0.0).any(axis=-1))
    found = there - shift[::-1]
    inside = np.all((found >= 0) & (found < 16), axis=1)
    was, is_now, new = (a[tuple(k.T)] for a, k in ((before, there[inside]), (after, found[inside]),
                                                   (seen, found[inside])))  # fmt: skip
    assert len(was) > 20 and np.array_equal(is_now, np.maximum(was, new)) and not new.all(axis=1).all()


CHANGES = {
    "moves": lambda of: replace(of, instances=scene((0.0, 0.0, 1.4)).instances),
    "goes": lambda of: replace(of, instances=of.instances[:1]),
    "is cut out": lambda of: replace(of, materials=[MATERIALS[0], replace(MATERIALS[1], alpha=0.1, alpha_mode="mask")]),
    "shrinks": lambda of: replace(of, meshes=[ROOM, box((-0.05,) * 3, (0.05,) * 3, material=1)]),
    "all is another": lambda of: scene((-1.2, 0.0, 0.0)),
}


@pytest.mark.parametrize(("preset", "what"), [("default", "moves"), *(("paper", what) for what in CHANGES)])
def test_nothing_is_left_of_what(device, preset, what):
    """Behind the camera's back: no cell there blocks, though the camera never looks again; all else stays."""
    made = renderer(device, scene(PLACE), preset)
    before = shown(made, RIGHT)
    here = around(made, PLACE)
    assert before[1][here[1]].any()
    made.scene = CHANGES[what](made.scene)
    after = shown(made, LEFT)
    assert not after[1][here[1]].any()
    if what != "all is another":
        assert np.all(after[1][~here[1]] >= before[1][~here[1]])
    for _ in range(MOVING_SYNCS + 1):
        assert not shown(made, LEFT)[1][here[1]].any()


@pytest.mark.parametrize("preset", WAYS)
def test_what_moves_blocks_for_its_frame_alone(device, preset):
    """Seen at each of its places it blocks there and nowhere where it has been; when it has come to rest it is kept,
    and with its next step gone."""
    made, places = renderer(device, scene(PLACE), preset), [(1.2, 0.0, 0.2 * k) for k in range(-5, 6)]
    shown(made, RIGHT)
    for k, place in enumerate(places):
        made.scene.instances = scene(place).instances
        found = shown(made, RIGHT)[1]
        assert found[around(made, place)[1]].any()
        for past in places[: max(0, k - 6)]:  # 1.2 m away and more
            assert not found[around(made, past)[1]].any()
    assert not shown(made, LEFT)[1][around(made, places[-1])[1]].any()
    shown(made, *[RIGHT] * MOVING_SYNCS)
    assert shown(made, LEFT)[1][around(made, places[-1])[1]].any()
    made.scene.instances = scene((0.0, 0.0, -1.4)).instances
    assert not shown(made, LEFT)[1][around(made, places[-1])[1]].any()


def test_the_same_frames_give_the_same_bits(device):
    """Camera, block and lamp move."""
    pictures = []
    for _ in range(2):
        made, seen = renderer(device, scene(PLACE), "paper"), []
        for k in range(4):
            lamp = replace(LAMP, position=(0.1 * k, 1.9, 0.0))
            made.scene = replace(scene((1.2, 0.0, 0.3 * (k // 2))), lights=[lamp])
            seen.append(made.render(towards(1.0, k - 1.0)).radiance)
        pictures.append(np.array(seen))
    assert np.array_equal(*pictures) and pictures[0].any()


@pytest.mark.parametrize("preset", WAYS)
def test_a_still_frame_is_what_it_was(device, preset):
    """What is kept of a frame adds nothing to its like; and a first frame is as without keeping."""
    made = renderer(device, scene(PLACE), preset)
    first = made.render(RIGHT).radiance
    assert np.array_equal(first, made.render(RIGHT).radiance)
    assert np.array_equal(first, renderer(device, scene(PLACE), preset, keep_surfels=False).render(RIGHT).radiance)


def test_the_scenes_own_surfels_need_no_keeping():
    with pytest.raises(SettingsError, match=r"all there in each frame.*keep_surfels=false"):
        CascadedLpvSettings.make(keep_surfels=True)


@pytest.mark.parametrize(("preset", "settings", "size"), [
    ("default", {"bounces": 2}, 288), ("paper", {}, 32), ("paper", {"bounces": 2}, 128),
])  # fmt: skip
def test_what_keeping_takes_is_said(device, preset, settings, size):
    """Bytes a cell, and a bit for those that are forgotten."""
    said = CascadedLpvSettings.__dataclass_fields__["keep_surfels"].metadata["cost"]
    before = kept_bytes(device)
    made = renderer(device, scene(PLACE), preset, **settings)
    cells = 2 * 16**3
    assert made.technique.settings.n**3 * made.technique.settings.cascades == cells
    assert kept_bytes(device) - before == size * cells and f" {size}" in said


def kept_bytes(device) -> int:
    gc.collect()
    return device.memory.by_label().get("LPV kept surfels", 0)
