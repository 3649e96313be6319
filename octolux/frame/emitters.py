"""Area lights and glowing surfaces as a few lights with shadow maps."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import pi

import numpy as np
from PIL import Image as Pillow

from ..scene.errors import OctoluxError
from ..scene.geometry.quadrilaterals import flaw
from ..scene.lights import AreaLight, PointLight
from ..scene.materials import Material
from ..scene.scene import Scene
from ..simulator.environment import LUMINANCE
from ..simulator.tonemap import srgb_decode


@dataclass(frozen=True, kw_only=True)
class EmitterLight(PointLight):
    """A patch of glowing surface, as if its light came from its middle.

    `intensity` is its flux / (4 pi). A share `beam` of the flux leaves as a cosine lobe around `axis` (unit length),
    the rest alike in all directions: I(w) = intensity * (4 beam max(0, w.axis) + 1 - beam). A flat patch has a beam of
    1, a glowing ball of 0.  square_radius: of a disk of the patch's area, m^2, times beam; at a distance d on the axis
    the disk's illuminance is exactly I / (d^2 + square_radius), and a ball's is I / d^2.
    lamp: the area light that the patch is a part of: what reaches a surface directly is then worked out from the area
    light itself (frame/area_lights.py), and this light says what of it is in shadow, and is reflected by what it meets.
    """

    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    beam: float = 0.0
    square_radius: float = 0.0
    lamp: AreaLight | None = None


@dataclass(frozen=True, eq=False)
class GlowingPatches:
    """Triangles: corners float64 (n, 3, 3), counter-clockwise where they shine to; radiance (n, 3), nits."""

    corners: np.ndarray
    radiance: np.ndarray

    def normals(self) -> np.ndarray:
        """float64 (n, 3), as long as the area."""
        c = self.corners
        return 0.5 * np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0])

    def flux(self) -> np.ndarray:
        """float64 (n, 3): pi times radiance times area."""
        return pi * self.radiance * np.linalg.norm(self.normals(), axis=1)[:, None]

    def chosen(self, which: np.ndarray) -> GlowingPatches:
        return GlowingPatches(self.corners[which], self.radiance[which])


@dataclass(frozen=True, eq=False)
class _Part:
    """Patches that one light stands for, all of `lamp`, the scene's light of that number, where that is not None."""

    patches: GlowingPatches
    lamp: AreaLight | None = None
    number: int = -1

    @property
    def flux(self) -> float:
        return float((self.patches.flux() @ LUMINANCE).sum())


def emitter_lights(scene: Scene, count: int) -> list[EmitterLight]:
    """The area lights and glowing surfaces of `scene` as at most `count` lights that send out all their flux.

    Each area light is a part of its own; where there are more than fit, the weakest are one part together with the
    glowing surfaces. The part with most flux is halved, by the way it faces and by place, until there are enough.
    Lights without a lamp come first, then those of each area light in the scene's order. Raises OctoluxError for an
    area light that is not flat or not convex.
    """
    if not count:
        return []
    parts = [part for part in _parts(scene, count) if len(part.patches.corners)]
    least = 0.5 * sum(part.flux for part in parts) / count
    parts = [replace(part, patches=_subdivided(part.patches, least)) for part in parts]
    while parts and len(parts) < count:
        parts.sort(key=lambda part: -part.flux)
        found = next(((n, h) for n, p in enumerate(parts) if (h := _halves(p.patches))), None)
        if found is None:
            break
        number, halves = found
        whole = parts.pop(number)
        parts += [replace(whole, patches=half) for half in halves]
    parts.sort(key=lambda part: part.number)
    return [_light(part) for part in parts]


def _parts(scene: Scene, count: int) -> list[_Part]:
    """A part for each area light, the strongest first, and one for all else that shines; at most `count`."""
    lights = [(n, light) for n, light in enumerate(scene.lights) if isinstance(light, AreaLight)]
    # Copies: a light that is in the scene twice is two lamps.
    lamps = [_Part(_quadrilateral(light), replace(light), n) for n, light in lights]
    lamps = sorted((part for part in lamps if part.flux > 0), key=lambda part: -part.flux)
    glow = _surfaces(scene)
    own = len(lamps) if len(lamps) + bool(len(glow.corners)) <= count else count - 1
    return [*lamps[:own], _Part(_joined([glow, *(part.patches for part in lamps[own:])]))]


def glowing_patches(scene: Scene) -> GlowingPatches:
    """The triangles of all area lights and glowing surfaces, those of double-sided ones on both sides."""
    return _joined([*(_quadrilateral(x) for x in scene.lights if isinstance(x, AreaLight)), _surfaces(scene)])


def _surfaces(scene: Scene) -> GlowingPatches:
    """The triangles of glowing surfaces."""
    found = []
    glowing = {n: _glow(m) for n, m in enumerate(scene.materials) if max(m.emissive) > 0}
    for instance in scene.instances:
        mesh = scene.meshes[instance.mesh]
        if mesh.material not in glowing:
            continue
        transform = instance.transform
        corners = mesh.positions[mesh.indices].astype(np.float64) @ transform[:3, :3].T + transform[:3, 3]
        if np.linalg.det(transform[:3, :3]) < 0:
            corners = corners[:, ::-1]
        sides = [corners, corners[:, ::-1]] if scene.materials[mesh.material].double_sided else [corners]
        found += [GlowingPatches(side, np.tile(glowing[mesh.material], (len(side), 1))) for side in sides]
    return _joined(found)


def _joined(patches: Iterable[GlowingPatches]) -> GlowingPatches:
    patches = [p for p in patches if len(p.corners)]
    if not patches:
        return GlowingPatches(np.zeros((0, 3, 3)), np.zeros((0, 3)))
    joined = GlowingPatches(np.concatenate([p.corners for p in patches]), np.concatenate([p.radiance for p in patches]))
    return joined.chosen(joined.flux().sum(axis=1) > 0)


def _glow(material: Material) -> np.ndarray:
    """Mean radiance (3,) of a material: its texture is taken as even."""
    glow = np.array(material.emissive, dtype=np.float64)
    if material.emissive_texture is None:
        return glow
    pixels = material.emissive_texture.image.pixels
    return glow * [_mean_linear(np.ascontiguousarray(pixels[..., channel])) for channel in range(3)]


def _mean_linear(channel: np.ndarray) -> float:
    """Mean of sRGB codes, uint8 (height, width), in linear light; of how often each code is there, for textures may be
    as large as memory allows."""
    counts = np.array(Pillow.fromarray(channel).histogram())
    return float(counts @ srgb_decode(np.arange(256) / 255.0) / channel.size)


def _quadrilateral(light: AreaLight) -> GlowingPatches:
    """Without a part that has no area. Raises OctoluxError for what is not flat or not convex."""
    if found := flaw(light.corners):
        problem, remedy = found
        raise OctoluxError(f"The corners of the area light '{light.name}' {problem}: {remedy}.")
    a, b, c, d = (np.asarray(corner, dtype=np.float64) for corner in light.corners)
    radiance = np.tile(np.asarray(light.radiance, dtype=np.float64), (2, 1))
    return _joined([GlowingPatches(np.array([[a, b, c], [a, c, d]]), radiance)])


def _subdivided(patches: GlowingPatches, least: float) -> GlowingPatches:
    """Triangles of more flux than `least`, half of a light's share, are cut into four: all parts can then be even."""
    while True:
        large = patches.flux() @ LUMINANCE > least
        if not large.any():
            return patches
        a, b, c = np.moveaxis(patches.corners[large], 1, 0)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        quarters = [np.stack(corners, axis=1) for corners in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        cut = GlowingPatches(np.concatenate(quarters), np.tile(patches.radiance[large], (4, 1)))
        patches = _joined([patches.chosen(~large), cut])


def _halves(part: GlowingPatches) -> tuple[GlowingPatches, GlowingPatches] | None:
    """The part cut in two: by the way it faces if it faces both ways, else across its longest side."""
    if len(part.corners) < 2:
        return None
    normals, flux = part.normals(), part.flux() @ LUMINANCE
    middle = part.corners.mean(axis=1)
    facing = normals @ normals[int(np.argmax(flux))]
    if (facing < 0).any():
        first = facing >= 0
    else:
        along = middle[:, int(np.argmax(np.ptp(middle, axis=0)))]
        order = np.argsort(along, kind="stable")
        half = int(np.searchsorted(np.cumsum(flux[order]), 0.5 * flux.sum()))
        first = np.zeros(len(order), bool)
        first[order[: min(max(half, 1), len(order) - 1)]] = True
    return part.chosen(first), part.chosen(~first)


def _light(whole: _Part) -> EmitterLight:
    part = whole.patches
    flux, normals = part.flux(), part.normals()
    weight = (flux @ LUMINANCE)[:, None]
    facing = (normals / np.linalg.norm(normals, axis=1)[:, None] * weight).sum(axis=0) / weight.sum()
    beam = float(np.linalg.norm(facing))
    axis = facing / beam if beam > 1e-9 else np.array([0.0, 0.0, 1.0])
    middle = (part.corners.mean(axis=1) * weight).sum(axis=0) / weight.sum()
    area = float(np.linalg.norm(normals, axis=1).sum())
    return EmitterLight(
        position=_vector(middle), intensity=_vector(flux.sum(axis=0) / (4.0 * pi)), axis=_vector(axis), beam=beam,
        square_radius=beam * area / pi, lamp=whole.lamp,
    )  # fmt: skip


def _vector(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in values)
    return x, y, z
