"""Picture: a rendered frame on the host, as layers of NumPy arrays, and as files."""

from __future__ import annotations

from functools import cached_property
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from .frame.frame import Frame
from .frame.views import View
from .gpu.device import Device
from .gpu_scene.clusters import CLUSTER_TRIANGLES
from .motion_vectors import motion_vectors
from .scene.environment import Environment
from .scene.scene import Scene
from .simulator import environment, tonemap
from .simulator.camera import octahedral_decode, unpack_normals

# Luminance of linear Rec. 709 (ITU-R BT.709-6, 3.2).
REC709_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


class Picture:
    """One frame. All layers are float32, linear Rec. 709, not exposed, [row from the top][column][channel].

    radiance: (height, width, 3), nits.  alpha: (height, width), the share of the pixel that surfaces cover,
    and of what is behind them that fog hides.
    display: uint8 (height, width, 4), exposed, tone-mapped, sRGB, opaque.
    paths: through each pixel, of a technique that traces them; else 0.
    exposure: EV100 of `display`.  object_names: the numbers of layer `object_id` and the names of their instances.

    The device's pictures are read when the Picture is made, so that later frames do not change it. With several samples
    a pixel, `radiance`, `alpha` and `display` are their mean; all other layers are those of the pixel's centre.
    """

    def __init__(
        self, device: Device, frame: Frame, exposure: float | None, tone_map: str = "neutral",
        before: tuple[View, Scene] | None = None,
    ):  # fmt: skip
        t = frame.targets
        self.exposure, self.tone_map = exposure, tone_map
        mean = device.read_texture(t.radiance, np.float32, 4)
        self.radiance, self.alpha = mean[..., :3], mean[..., 3]
        self.display = device.read_texture(t.display, np.uint8, 4)
        self._surface = device.read_texture(t.surface, np.uint32, 4)
        self._depth = device.read_texture(t.depth, np.float32, 1)[..., 0]
        direct = device.read_texture(t.direct, np.float32, 4)
        self._direct, self._noise = direct[..., :3], direct[..., 3] if frame.paths else np.zeros_like(direct[..., 3])
        self.paths = frame.paths
        self._indirect = device.read_texture(frame.indirect, np.float32, 4)[..., :3] if frame.indirect else None
        self._irradiance = self._optional(device, frame.irradiance)
        self._specular = self._optional(device, frame.specular)
        fog = (frame.inscattered, frame.transmittance)
        self._fog = [device.read_texture(part, np.float32, 4)[..., :3] for part in fog if part is not None]
        emissive = t.emissive if frame.gpu_scene.has_emission else None
        self._emissive = self._optional(device, emissive)
        self._ids = device.read_texture(t.ids, np.uint32, 1)[..., 0]
        # By the time layers are asked for, the scene may hold other instances.
        self._view, self._drawn, self._before = frame.views[0], frame.gpu_scene.drawn, before
        self.object_names = {n + 1: i.name for n, i in enumerate(frame.scene.instances)}
        self._surroundings = Environment() if frame.transparent else frame.surroundings

    def _optional(self, device: Device, texture: Any) -> np.ndarray:
        if texture is None:
            return np.zeros((*self.radiance.shape[:2], 4), np.float32)
        return device.read_texture(texture, np.float32, 4)

    @property
    def rgb(self) -> np.ndarray:
        """float32 (height, width, 3), nits."""
        return self.radiance

    @property
    def noise(self) -> np.ndarray:
        """Standard error of the pixels' luminance, nits, float32 (height, width); 0 for techniques without noise."""
        return self._noise

    @property
    def relative_error(self) -> float:
        """Root mean square of `noise` over the mean luminance of the picture."""
        mean = float((self.radiance.astype(np.float64) @ REC709_LUMINANCE).mean())
        return float(np.sqrt((self._noise.astype(np.float64) ** 2).mean())) / max(mean, 1e-30)

    @property
    def mask(self) -> np.ndarray:
        """bool (height, width): where a surface is seen."""
        return self._depth > 0

    def mean_luminance(self) -> float:
        """Mean luminance of what is seen, nits: surfaces, and the surroundings unless they are black."""
        luminance = self.radiance.astype(np.float64) @ REC709_LUMINANCE
        seen = self.mask | (luminance > 0)
        return float(luminance[seen].mean()) if seen.any() else 0.0

    @property
    def energy(self) -> dict[str, float]:
        """Mean direct and indirect radiance (nits, mean of the channels) of what is seen."""
        count = max(1, int(self.mask.sum()))
        means = {name: float(self.layers[name].sum(dtype=np.float64)) / (3 * count) for name in ("direct", "indirect")}
        return {f"{name}_mean": mean for name, mean in means.items()}

    def save(self, path: str | Path) -> None:
        """Write a .png or .exr, see output.write_picture. Raises OctoluxError."""
        from .output import write_picture

        write_picture(self, path)

    @cached_property
    def layers(self) -> dict[str, np.ndarray]:
        """All layers by name, as docs/conventions.md lists them: (height, width, 3) or (height, width)."""
        s, mask = self._surface, self.mask
        unorm16 = np.float32(1 / 65535)
        base = np.stack([s[..., 2] & 0xFFFF, s[..., 2] >> 16, s[..., 3] & 0xFFFF], axis=-1).astype(np.float32) * unorm16
        metallic = (s[..., 3] >> 24).astype(np.float32) / 255
        albedo = base * (1 - metallic[..., None])
        irradiance = self._irradiance[..., :3] * self._irradiance[..., 3:]
        specular = self._specular[..., :3]
        gathered = albedo / np.float32(pi) * irradiance + specular
        fog, transmittance = self._fog or (np.zeros_like(self.radiance), np.ones_like(self.radiance))
        normal = np.where(mask[..., None], unpack_normals(s[..., 0]), 0).astype(np.float32)
        return {
            "radiance": self.radiance,
            "direct": self._direct,
            "indirect": self._indirect if self._indirect is not None else gathered * mask[..., None],
            "irradiance": irradiance,
            "specular": specular,
            "emissive": self._emissive[..., :3],
            "albedo": albedo * mask[..., None],
            "normal": normal,
            "position": self._positions(),
            "depth": self._depth,
            "alpha": self.alpha,
            "noise": self.noise,
            "object_id": self._object_ids(),
            "fog": fog,
            "transmittance": transmittance,
            "motion": self._motion(),
        }

    def display16(self) -> np.ndarray:
        """`display` with 16 bits: uint16 (height, width, 4), worked out here from `radiance`, without filters."""
        return self._displayed(self.radiance, np.ones_like(self.alpha), 16)

    def cutout(self, bits: int = 8) -> np.ndarray:
        """The picture without its surroundings: uint8 or uint16 (height, width, 4), straight alpha, and black
        where that is 0.

        Exact for a `transparent` renderer. Else, with several samples a pixel, what a map shows behind an edge is taken
        from the pixel's centre.
        """
        alone = np.where(self.alpha[..., None] > 0, self.radiance - self._surroundings_seen(), 0.0)
        return self._displayed(alone / np.where(self.alpha > 0, self.alpha, 1.0)[..., None], self.alpha, bits)

    def _displayed(self, radiance: np.ndarray, alpha: np.ndarray, bits: int) -> np.ndarray:
        signal = tonemap.signal(radiance, self.exposure or 0.0, self.tone_map)
        top = (1 << bits) - 1
        codes = np.concatenate([signal, np.clip(alpha, 0.0, 1.0)[..., None]], axis=-1) * top + 0.5
        return codes.astype(np.uint8 if bits == 8 else np.uint16)

    @property
    def geometric_normal(self) -> np.ndarray:
        """float32 (height, width, 3): the triangle's normal, towards the camera; zero where nothing is seen."""
        word = self._surface[..., 1]
        codes = np.stack([word & 4095, (word >> 12) & 4095], axis=-1) / 4095 * 2 - 1
        return np.where(self.mask[..., None], octahedral_decode(codes), 0).astype(np.float32)

    def _surroundings_seen(self) -> np.ndarray:
        """What of `radiance` lies behind the surfaces."""
        view = self._view
        if view.perspective:
            directions = view.forward + self._offsets()
        else:
            directions = np.broadcast_to(view.forward, self.radiance.shape)
        return environment.radiance(self._surroundings, directions) * (1.0 - self.alpha)[..., None]

    def _offsets(self) -> np.ndarray:
        """From the middle of the picture to each pixel, in units of the view's axes: (height, width, 3)."""
        view, (height, width) = self._view, self._depth.shape
        across = ((np.arange(width) + 0.5) / width * 2 - 1)[None, :, None] * view.right
        upward = (1 - (np.arange(height) + 0.5) / height * 2)[:, None, None] * view.up
        return across + upward

    def _positions(self) -> np.ndarray:
        view, offset, depth = self._view, self._offsets(), self._depth[..., None]
        if view.perspective:
            position = view.position + depth * (view.forward + offset)
        else:
            position = view.position + offset + depth * view.forward
        return (position * self.mask[..., None]).astype(np.float32)

    def _object_ids(self) -> np.ndarray:
        """uint32 (height, width): number of the instance in the scene plus one, 0 where nothing is seen."""
        if not len(self._drawn.numbers):
            return np.zeros(self._ids.shape, np.uint32)
        item = np.where(self._ids > 0, (self._ids - 1) // CLUSTER_TRIANGLES, 0)
        number = self._drawn.numbers[self._drawn.item_instance[item]] + 1
        return np.where(self._ids > 0, number, 0).astype(np.uint32)

    def _motion(self) -> np.ndarray:
        before, scene = self._before or (self._view, None)
        return motion_vectors(self._ids, self._positions(), self._drawn, self._view, before, scene)
