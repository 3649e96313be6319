"""What tests of the path tracer share: a renderer for many scenes, means with their errors, surfaces, albedos."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
from gpu_tools import scene_of, small_settings

from octolux.picture import Picture
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.materials import Material
from octolux.scene.meshes import Mesh
from octolux.scene.scene import Scene
from octolux.simulator import brdf
from octolux.simulator.environment import LUMINANCE
from octolux.techniques.path_tracer.settings import PathTracerSettings

ERRORS = 4.0
"""How many standard errors a mean may lie from what is expected: chance alone exceeds them in 6e-5 of all cases."""

ABOVE = Camera.look_at((0.0, 1.5, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), orthographic_height=2.0)
"""Straight down on 2 m by 2 m of the floor; lamps at y = 2 are behind it."""

WHITE = Material(specular=0.0, base_color=(0.8, 0.8, 0.8))


class Tracer:
    """One renderer for many scenes: its passes are made anew only where a scene or a setting needs others."""

    def __init__(self, device, size: tuple[int, int] = (16, 16)):
        self.device, self.size = device, size
        self.renderer: Renderer | None = None

    def __call__(self, scene: Scene, camera: Camera = ABOVE, **settings: Any) -> Picture:
        """The scene's picture; samples: 64 unless said otherwise."""
        wanted = PathTracerSettings.make("default", **{"samples": 64, **settings})
        if self.renderer is None:
            self.renderer = Renderer(
                scene, "path-tracer", size=self.size, device=self.device, default_light=False, exposure=0.0,
                frame_settings=small_settings(),
            )  # fmt: skip
        self.renderer.scene, self.renderer.technique.settings = scene, wanted
        return self.renderer.render(camera)


def luminance(radiance) -> np.ndarray:
    return np.asarray(radiance, dtype=np.float64) @ LUMINANCE


def mean_and_error(picture: Picture, where=None) -> tuple[float, float]:
    """Mean luminance and its standard error; the pixels' errors are independent."""
    where = np.ones(picture.alpha.shape, bool) if where is None else where
    noise = picture.noise[where].astype(np.float64)
    return float(luminance(picture.radiance[where]).mean()), float(np.sqrt((noise**2).sum())) / len(noise)


def assert_mean(picture: Picture, expected, where=None, rounding: float = 1e-5) -> None:
    """The mean over the pixels `where` is that of `expected` (broadcast, rgb); rounding: relative."""
    where = np.ones(picture.alpha.shape, bool) if where is None else where
    mean, error = mean_and_error(picture, where)
    target = float(luminance(np.broadcast_to(expected, picture.radiance.shape)[where]).mean())
    off = (mean - target) / max(error, 1e-30)
    text = f"{mean:.6g} should be {target:.6g}: {off:+.1f} standard errors of {error:.2g}"
    assert abs(mean - target) <= ERRORS * error + rounding * target, text


def assert_picture(picture: Picture, expected, block: int = 4, rounding: float = 1e-5) -> None:
    """The same for blocks of `block` x `block` pixels and for the whole picture."""
    expected = np.broadcast_to(expected, picture.radiance.shape)
    assert_mean(picture, expected, rounding=rounding)
    rows, columns = np.indices(picture.alpha.shape) // block
    for row in range(rows.max() + 1):
        for column in range(columns.max() + 1):
            assert_mean(picture, expected, (rows == row) & (columns == column), rounding)


def floor(size: float = 4.0, material: int = 0, y: float = 0.0) -> Mesh:
    s = 0.5 * size
    return quad([(-s, y, s), (s, y, s), (s, y, -s), (-s, y, -s)], material=material)


def ceiling(size: float = 1.0, material: int = 0, y: float = 2.0, x: float = 0.0) -> Mesh:
    """Faces down."""
    s = 0.5 * size
    return quad([(x - s, y, -s), (x + s, y, -s), (x + s, y, s), (x - s, y, s)], material=material)


def floor_scene(*meshes: Mesh, materials=(WHITE,), **rest: Any) -> Scene:
    """A floor of the first material, and more."""
    return scene_of([floor(), *meshes], list(materials), **rest)


def inward_and_flat(mesh: Mesh) -> Mesh:
    """Seen from inside, each triangle with its own normal."""
    corners = mesh.positions[mesh.indices[:, ::-1]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.repeat(normals / np.linalg.norm(normals, axis=1, keepdims=True), 3, axis=0)
    return replace(
        mesh, positions=corners.reshape(-1, 3), normals=normals.astype(np.float32),
        uvs=np.zeros((len(normals), 2), np.float32), tangents=np.tile(np.float32([1, 0, 0, 1]), (len(normals), 1)),
        indices=np.arange(len(normals), dtype=np.uint32).reshape(-1, 3),
    )  # fmt: skip


def directional_albedo(material: brdf.Surface, eye: np.ndarray, steps: int = 384) -> np.ndarray:
    """What +z surfaces send to unit `eye` (3,) of even light of radiance 1: (3,), by the midpoint rule: the diffuse
    part over the cosine's disk, the specular over half vectors spaced in D (n.h), crowded where n.h falls to 0, as in
    simulator/environment.py. Errs by 2e-5 at most where n.v is above 0.1 (against four times the steps)."""
    share, turn = np.meshgrid(*[(np.arange(steps) + 0.5) / steps] * 2, indexing="ij")
    normal = np.array([0.0, 0.0, 1.0])

    def around(cosine):
        sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
        return np.stack([sine * np.cos(2.0 * pi * turn), sine * np.sin(2.0 * pi * turn), cosine], axis=-1)

    diffuse, _ = brdf.diffuse_and_specular(material, normal, around(np.sqrt(share)), eye)
    alpha = float(brdf.alpha_of(material.roughness))
    rest, weight = (1.0 - share) ** 3, 3.0 * (1.0 - share) ** 2
    n_h = np.sqrt(rest / (1.0 + (alpha * alpha - 1.0) * (1.0 - rest)))
    half = around(n_h)
    v_h = half @ eye
    light = 2.0 * v_h[..., None] * half - eye
    _, specular = brdf.diffuse_and_specular(material, normal, light, eye)
    # dl = 4 v.h dh, and dh has the density D n.h.
    jacobian = np.where((light[..., 2] > 0) & (v_h > 0), light[..., 2] * 4.0 * v_h * weight, 0.0)
    specular = specular * (jacobian / (brdf.ggx_distribution(n_h, alpha) * n_h))[..., None]
    return pi * diffuse.mean(axis=(0, 1)) + specular.mean(axis=(0, 1))
