"""The path tracer's pictures again and again: the same bits, seeds, tiles, progress, noise, scenes that change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from path_tracing import (
    ABOVE,
    WHITE,
    Tracer,
    assert_mean,
    ceiling,
    directional_albedo,
    floor,
    floor_scene,
    luminance,
    mean_and_error,
)

from octolux.scene.builtin.shapes import box
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.lights import PointLight
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.simulator import brdf

SIZE = (48, 24)
ASIDE = Camera.look_at((2.0, 1.6, 2.2), (0.0, 0.2, 0.0), vertical_fov=0.8)
LAMP = PointLight(position=(0.3, 1.5, 0.4), intensity=(2.0, 1.5, 1.0))


@pytest.fixture(scope="module")
def trace(device) -> Tracer:
    return Tracer(device, SIZE)


def at(x: float, y: float = 0.3) -> Instance:
    place = np.eye(4)
    place[:3, 3] = x, y, 0.0
    return Instance(1, place)


def everything(x: float = 0.0) -> Scene:
    """A floor, a glossy blended box, a glowing plate, a lamp and a sky."""
    materials = (
        WHITE,
        Material(base_color=(0.9, 0.3, 0.2), roughness=0.3, alpha_mode="blend", alpha=0.8),
        Material(base_color=(0.1, 0.1, 0.1), emissive=(3.0, 5.0, 8.0), double_sided=True),
    )
    scene = floor_scene(
        box((-0.3, -0.3, -0.3), (0.3, 0.3, 0.3), material=1), ceiling(0.8, material=2, y=1.2, x=-0.8),
        materials=materials, lights=[LAMP], environment=Environment((0.2, 0.3, 0.5)),
    )  # fmt: skip
    scene.instances[1] = at(x)
    return scene


def same(a, b) -> bool:
    """All bits of what is traced."""
    layers = all(np.array_equal(a.layers[name], b.layers[name]) for name in ("radiance", "direct", "indirect", "alpha"))
    return layers and np.array_equal(a.noise, b.noise)


def test_the_same_bits_and_other_seeds(device, trace):
    scene = everything()
    first, again, other = (trace(scene, ASIDE, samples=8, seed=seed) for seed in (3, 3, 4))
    fresh = Tracer(device, SIZE)(everything(), ASIDE, samples=8, seed=3)
    assert same(first, again) and same(first, fresh)
    # The sky beside the scene is the same; what is seen of surfaces is not.
    assert 0.5 < first.mask.mean() < 1
    assert np.mean(np.any(first.radiance != other.radiance, axis=-1)[first.mask]) > 0.99
    # Two independent pictures of one scene: means within their errors.
    (a, b), errors = zip(*(mean_and_error(p) for p in (first, other)), strict=True)
    assert abs(a - b) <= 4 * np.hypot(*errors)


def test_tiles_do_not_matter(trace, monkeypatch):
    scene = everything()
    whole = trace(scene, ASIDE, samples=4)
    technique = trace.renderer.technique
    monkeypatch.setattr(technique, "_adapt", lambda *args, **kwargs: None)
    for paths in (1, 48 * 5, 48 * 7 + 11):
        monkeypatch.setattr(technique, "_paths_per_dispatch", paths)
        assert same(trace(scene, ASIDE, samples=4), whole), paths


def test_tiles_grow_and_shrink_with_the_time_they_take(trace):
    technique = trace.renderer.technique
    technique._paths_per_dispatch = 1 << 12
    technique._adapt(1.0, full=True)
    assert technique._paths_per_dispatch == 1 << 11
    technique._adapt(1e-3, full=False)  # a short rest of a picture
    assert technique._paths_per_dispatch == 1 << 11
    technique._adapt(1e-3, full=True)
    assert technique._paths_per_dispatch == 1 << 12


def test_progress_counts_and_stops(trace):
    scene = everything()
    trace(scene, ASIDE, samples=1)
    told: list[tuple[int, int]] = []
    trace.renderer.progress = lambda done, of: bool(told.append((done, of))) or done < 5
    try:
        stopped = trace(scene, ASIDE, samples=12)
    finally:
        trace.renderer.progress = None
    assert told == [(n, 12) for n in range(1, 6)]
    assert stopped.paths == 5 and same(stopped, trace(scene, ASIDE, samples=5))


def test_noise_stops_when_it_is_reached(trace):
    scene = everything()
    picture = trace(scene, ASIDE, samples=1 << 12, noise=0.1)
    assert picture.relative_error <= 0.1
    taken = picture.paths
    assert 16 <= taken < 1 << 12 and taken & (taken - 1) == 0
    before = trace(scene, ASIDE, samples=taken // 2)
    assert before.relative_error > 0.1 or taken == 16
    assert same(picture, trace(scene, ASIDE, samples=taken))
    # All samples where it is not reached.
    assert trace(scene, ASIDE, samples=20, noise=1e-3).paths == 20


def test_noise_is_the_standard_error(trace):
    """In n samples: that of independent ones, s / sqrt(n), where s^2 is the variance of one sample, here from 64 seeds.
    Stratified samples err less. Their correlation r is negative but above -1 / (n - 1), since no variance is negative,
    and the scatter within a picture, (1 - r) s^2, is then larger by n / (n - 1) at most."""
    scene, n = everything(), 16
    single = np.stack([luminance(trace(scene, ASIDE, samples=1, seed=1000 + seed).radiance) for seed in range(64)])
    pictures = [trace(scene, ASIDE, samples=n, seed=seed) for seed in range(16)]
    means = np.stack([luminance(p.radiance) for p in pictures])
    told = np.mean([(p.noise.astype(np.float64) ** 2).mean() for p in pictures])
    ratio = told * n / single.var(axis=0, ddof=1).mean()
    # 64 and 256 samples of 1152 pixels, whose squares scatter some six times as much as those of a normal distribution.
    tolerance = 6 * np.sqrt(2 / 1152 * (1 / 64 + 1 / 256))
    assert 1 - 4 * tolerance <= ratio <= n / (n - 1) + 4 * tolerance
    scatter = means.var(axis=0, ddof=1).mean()
    assert 0.1 < scatter / told < 1.05
    # The mean of the pixels is as certain as independent pixels make it: chi, 15 degrees of freedom, 1e-3 either side.
    independent = means.mean(axis=(1, 2)).std(ddof=1) / np.sqrt(scatter / means[0].size)
    assert 0.48 < independent < 1.58


def test_layers_are_parts_of_the_picture(trace):
    """radiance = emissive or surroundings + direct + indirect, with paths through the pixels' centres."""
    scene = everything()
    scene.materials[1] = replace(scene.materials[1], alpha_mode="opaque")
    picture = trace(scene, ASIDE, samples=8, pixel="centre")
    layers = picture.layers
    background = np.where(picture.mask[..., None], 0.0, np.array([0.2, 0.3, 0.5]))
    total = layers["emissive"] + background + layers["direct"] + layers["indirect"]
    np.testing.assert_allclose(picture.radiance, total, rtol=1e-5)
    assert np.array_equal(picture.alpha, picture.mask.astype(np.float32))
    assert layers["emissive"].any() and layers["direct"].any() and layers["indirect"].any()
    assert not layers["direct"][~picture.mask].any() and not layers["indirect"][~picture.mask].any()


CHANGES = {
    "moved": lambda scene: scene.instances.__setitem__(1, at(0.5)),
    "lamp moved": lambda scene: scene.instances.__setitem__(2, Instance(2, at(0.4, 0.3).transform)),
    "brighter": lambda scene: scene.materials.__setitem__(2, replace(scene.materials[2], emissive=(9.0, 1.0, 1.0))),
    "other light": lambda scene: scene.lights.__setitem__(0, replace(LAMP, position=(-0.5, 0.9, 0.2))),
    "other sky": lambda scene: setattr(scene, "environment", Environment((0.9, 0.1, 0.1))),
    "taken away": lambda scene: scene.instances.__delitem__(1),
    "no sky": lambda scene: setattr(scene, "environment", Environment()),
}


@pytest.fixture(scope="module")
def fresh(device) -> Tracer:
    return Tracer(device, SIZE)


@pytest.mark.parametrize("kind", CHANGES)
def test_what_changes_is_seen(trace, fresh, kind):
    """A renderer that saw the scene before shows the change as one that never did. The refitted tree is another, but a
    ray's nearest hit is the same: bits may differ only where rays graze edges."""
    before = trace(everything(), ASIDE, samples=8)
    changed = trace.renderer.scene
    CHANGES[kind](changed)
    after = trace(changed, ASIDE, samples=8)
    fresh.renderer = None
    again = everything()
    CHANGES[kind](again)
    new = fresh(again, ASIDE, samples=8)
    assert np.mean(np.any(after.radiance != new.radiance, axis=-1)) <= 0.01
    assert np.mean(np.any(after.radiance != before.radiance, axis=-1)[before.mask]) > 0.5


def test_an_empty_scene_and_one_sample(device):
    picture = Tracer(device)(Scene(environment=Environment((1.0, 2.0, 3.0)), exposure=0.0), samples=1)
    np.testing.assert_allclose(picture.radiance, np.broadcast_to([1, 2, 3], (16, 16, 3)), rtol=1e-6)
    assert not picture.alpha.any()


def test_an_orthographic_camera_and_the_near_plane(trace):
    """What lies before the near plane is not seen, but casts its shadow."""
    albedo = directional_albedo(brdf.surface(WHITE.base_color, 0.0, 1.0, 0.0), np.array([0.0, 0.0, 1.0]), 64)
    scene = floor_scene(ceiling(4.0, y=1.0), environment=Environment((1.0, 1.0, 1.0)))
    scene.meshes[1] = floor(0.5, y=1.0)
    near = replace(ABOVE, near=0.8)
    far = trace(scene, ABOVE, samples=16, paths="direct")
    picture = trace(scene, near, samples=16, paths="direct")
    assert np.all(picture.layers["depth"] > 0.8)
    middle, rim = (slice(10, 14), slice(20, 28)), (slice(10, 14), slice(0, 4))
    assert_mean(far, albedo, np.isin(far.layers["depth"], np.float32([0.5])))
    assert luminance(picture.radiance[middle]).mean() < luminance(picture.radiance[rim]).mean() < albedo.max()
