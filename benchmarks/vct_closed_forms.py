"""Cones through the device's octree where the answer is known: slabs, skies, boxes, a beam on a wall."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians

import numpy as np

from octolux.gpu.device import Device
from octolux.scene.builtin.shapes import box
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.lights import DirectionalLight, PointLight
from octolux.scene.materials import Material
from octolux.scene.scene import Scene
from octolux.simulator.form_factors import point_to_parallel_square
from octolux.simulator.voxels.cones import COVERS

from .lab import device
from .registry import aim, at_least, at_most, figure, within
from .vct_scene import DEPTH, PRESETS, Watched, from_above, level, scene_of, watched

ALBEDO = (0.6, 0.3, 0.1)
PAINT = Material(base_color=ALBEDO, specular=0.0)
MIRROR = Material(metallic=1.0, roughness=0.1)
SKY = (2.0, 1.0, 0.5)
STEPS, LAYERS, OPACITY = (0.125, 0.25, 0.5, 1.0), 5, 0.1
CEILING = 45
"""Voxels of a slab's ceiling over its floor."""


def beam(device: Device, words: str, up: bool = False) -> np.ndarray:
    """Irradiance over the closed form's, (3,): a ceiling of known albedo is lit straight from below, past a small
    receiver whose shadow is on it. E = albedo * illuminance * (F of the ceiling - F of the shadow).

    up: the ceiling looks there, and shows its back."""
    edge = 0.1
    sun = DirectionalLight(direction=(0.0, 1.0, 0.0), illuminance=(4.0, 4.0, 4.0))
    scene = scene_of([level(1.0, 1.0, up=up), level(0.0, edge, up=True)], [PAINT], lights=[sun])
    found = watched(device, scene, from_above(0.5, 0.1), words).picture.layers["irradiance"].mean(axis=(0, 1))
    factor = point_to_parallel_square(2.0, 1.0) - point_to_parallel_square(2.0 * edge, 1.0)
    return found / (4.0 * np.array(ALBEDO) * factor)


def closed_box() -> Scene:
    return scene_of([box((-1.0, 0.0, -1.0), (1.0, 2.0, 1.0), inward=True)], [PAINT])


def visibility(made: Watched) -> np.ndarray:
    """Ambient visibility of the pixels that see something."""
    return device().read_texture(made.technique.diffuse.visibility, np.float32, 1)[..., 0][made.picture.mask]


def _slab(cover: str, step: float, layers: int) -> float:
    """What a mirror shows, in its middle, of a ceiling that sends light behind black layers that let some through."""
    edge = 2.0 / (2**DEPTH - 3)  # of a voxel: these squares are as wide as the scene (surfaces.around)
    clear = Material(base_color=(0.0,) * 3, specular=0.0, alpha=OPACITY, alpha_mode="blend")
    slab = [level((CEILING // 3 + i) * edge, 1.0, up=False, material=2) for i in range(layers)]
    mirror, ceiling = level(0.0, 1.0, up=True, material=1), level(CEILING * edge, 1.0, up=False)
    scene = scene_of([mirror, ceiling, *slab], [PAINT, MIRROR, clear])
    made = watched(device(), scene, from_above(0.3, 0.05), f"default,cover={cover},step={step}")
    made.shine(lambda facing: np.where(np.arange(2**DEPTH)[:, None, None] > CEILING, facing, 0.0))
    return float(made.specular().mean())


@figure("vct_slab", group="vct", unit="share", bound={cover: at_most(0.02) for cover in COVERS})
def vct_slab() -> dict[str, float]:
    """A slab of five layers of 0.1 lets 1 - 0.5 through, or 0.9^5 of a medium: largest error in steps of 1/8 to 1."""
    exact = {"surfaces": 1.0 - LAYERS * OPACITY, "medium": (1.0 - OPACITY) ** LAYERS}
    found = {}
    for cover in COVERS:
        through = [_slab(cover, step, LAYERS) / _slab(cover, step, 0) for step in STEPS]
        found[cover] = float(np.abs(np.array(through) - exact[cover]).max())
    return found


@figure("vct_visibility", group="vct", unit="share", bound={
    **{f"{preset}_open": at_least(0.95) for preset in PRESETS},
    **{f"{preset}_closed": at_most(0.05) for preset in PRESETS},
})  # fmt: skip
def vct_visibility() -> dict[str, float]:
    """Ambient visibility of an open floor, the least, and of the floor of a closed box, the most, in any pixel."""
    floor = scene_of([level(0.0, 1.0, up=True)], [PAINT])
    found: dict[str, float] = {}
    for preset in PRESETS:
        seen = [visibility(watched(device(), s, from_above(1.0, 2.0), preset)) for s in (floor, closed_box())]
        found |= {f"{preset}_open": float(seen[0].min()), f"{preset}_closed": float(seen[1].max())}
    return found


@figure("vct_sky", group="vct", unit="x", bound={"least": within(1.0, 0.03), "most": within(1.0, 0.03)})
def vct_sky() -> dict[str, float]:
    """Irradiance of an open floor by cones that see a uniform sky, over pi L: of the pixels and colours the least, and
    the most."""
    floor = replace(scene_of([level(0.0, 1.0, up=True)], [PAINT]), environment=Environment(SKY))
    made = watched(device(), floor, from_above(1.0, 1.9))
    ratios = made.irradiance(sky=True)[made.picture.mask] / (pi * np.array(SKY))
    return {"least": float(ratios.min()), "most": float(ratios.max())}


@figure("vct_furnace", group="vct", unit="x", bound={
    **{f"{preset}_{kind}": within(1.0, 0.05) for preset in PRESETS for kind in ("mean", "most")},
    **{f"{preset}_least": aim(">= 0.95") for preset in PRESETS},
})  # fmt: skip
def vct_furnace() -> dict[str, float]:
    """Irradiance between walls of one radiance over pi L, on five sides of a box: its mean, least and most in pixels,
    where corners are the worst."""
    found: dict[str, float] = {}
    inside = Camera.look_at((-0.5, 0.7, 0.8), (0.3, 0.9, -1.0), vertical_fov=radians(100.0))
    for preset in PRESETS:
        made = watched(device(), closed_box(), inside, preset)
        made.shine(lambda facing: facing)
        ratios = made.irradiance() / pi
        kinds = {"mean": ratios.mean(), "least": ratios.min(), "most": ratios.max()}
        found |= {f"{preset}_{kind}": float(value) for kind, value in kinds.items()}
    return found


@figure("vct_beam", group="vct", unit="x", bound=within(1.0, 0.15))
def vct_beam() -> dict[str, float]:
    """Irradiance by a lit ceiling of known albedo over the closed form's: of the colours that which is most off."""
    ratios = {preset: beam(device(), preset) for preset in PRESETS}
    return {preset: float(found[np.abs(found - 1.0).argmax()]) for preset, found in ratios.items()}


@figure("vct_endless", group="vct", unit="x")
def vct_endless() -> dict[str, float]:
    """Indirect irradiance in a closed room of one albedo a, a lamp in its middle, over what walls receive on the mean:
    a / (1 - a) of the lamp's flux. Four bounces, with what further ones bring and without, by depth."""
    lamp, albedo = PointLight(position=(0.0, 1.0, 0.0), intensity=(5.0, 5.0, 5.0)), 0.8
    grey = Material(base_color=(albedo,) * 3, specular=0.0)
    room = replace(closed_box(), materials=[grey], lights=[lamp])
    along = Camera.look_at(lamp.position, (0.0, 1.0, -1.0), vertical_fov=0.5 * pi)  # shows all of a wall alike
    expected = 4.0 * pi * 5.0 / 24.0 * albedo / (1.0 - albedo)
    found: dict[str, float] = {}
    for depth in (DEPTH, 8):
        for name, endless in (("endless", "true"), ("four", "false")):
            made = watched(device(), room, along, f"default,depth={depth},bounces=4,endless={endless}", (24, 24))
            found[f"{name}_{depth}"] = float(made.picture.layers["irradiance"].mean()) / expected
    return found
