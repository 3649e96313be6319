"""Picture: a rendered frame on the host, as layers of NumPy arrays, and as files."""

from __future__ import annotations

from functools import cached_property
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from .frame.frame import Frame
from .gpu.device import Device
from .gpu_scene.clusters import CLUSTER_TRIANGLES
from .simulator.camera import octahedral_decode, unpack_normals

# Luminance of linear Rec. 709 (ITU-R BT.709-6, 3.2).
REC709_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


class Picture:
    """One frame. All layers are float32, linear Rec. 709, not exposed, [row from the top][column][channel].

    The device's pictures are read when the Picture is made, so that later frames do not change it.
    """

    def __init__(self, device: Device, frame: Frame, exposure: float | None):
        t = frame.targets
        self.exposure = exposure
        self.radiance = device.read_texture(t.radiance, np.float32, 4)[..., :3]
        self.display = device.read_texture(t.display, np.uint8, 4)
        self._surface = device.read_texture(t.surface, np.uint32, 4)
        self._depth = device.read_texture(t.depth, np.float32, 1)[..., 0]
        self._direct = device.read_texture(t.direct, np.float32, 4)[..., :3]
        self._irradiance = self._optional(device, frame.irradiance)
        self._specular = self._optional(device, frame.specular)
        emissive = t.emissive if frame.gpu_scene.has_emission else None
        self._emissive = self._optional(device, emissive)
        self._ids = device.read_texture(t.ids, np.uint32, 1)[..., 0]
        # By the time layers are asked for, the scene may hold other instances.
        self._view, self._instance_of_item = frame.views[0], frame.gpu_scene.instance_of_item

    def _optional(self, device: Device, texture: Any) -> np.ndarray:
        if texture is None:
            return np.zeros((*self.radiance.shape[:2], 4), np.float32)
        return device.read_texture(texture, np.float32, 4)

    @property
    def rgb(self) -> np.ndarray:
        """float32 (height, width, 3), nits."""
        return self.radiance

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
        normal = np.where(mask[..., None], unpack_normals(s[..., 0]), 0).astype(np.float32)
        return {
            "radiance": self.radiance,
            "direct": self._direct,
            "indirect": (albedo / np.float32(pi) * irradiance + specular) * mask[..., None],
            "irradiance": irradiance,
            "specular": specular,
            "emissive": self._emissive[..., :3],
            "albedo": albedo * mask[..., None],
            "normal": normal,
            "position": self._positions(),
            "depth": self._depth,
            "object_id": self._object_ids(),
        }

    @property
    def geometric_normal(self) -> np.ndarray:
        """float32 (height, width, 3): the triangle's normal, towards the camera; zero where nothing is seen."""
        word = self._surface[..., 1]
        codes = np.stack([word & 4095, (word >> 12) & 4095], axis=-1) / 4095 * 2 - 1
        return np.where(self.mask[..., None], octahedral_decode(codes), 0).astype(np.float32)

    def _positions(self) -> np.ndarray:
        view = self._view
        height, width = self._depth.shape
        across = ((np.arange(width) + 0.5) / width * 2 - 1)[None, :, None] * view.right
        upward = (1 - (np.arange(height) + 0.5) / height * 2)[:, None, None] * view.up
        offset, depth = across + upward, self._depth[..., None]
        if view.perspective:
            position = view.position + depth * (view.forward + offset)
        else:
            position = view.position + offset + depth * view.forward
        return (position * self.mask[..., None]).astype(np.float32)

    def _object_ids(self) -> np.ndarray:
        """uint32 (height, width): number of the drawn instance plus one, 0 where nothing is seen."""
        item = np.where(self._ids > 0, (self._ids - 1) // CLUSTER_TRIANGLES, 0)
        if not len(self._instance_of_item):
            return np.zeros(item.shape, np.uint32)
        return np.where(self._ids > 0, self._instance_of_item[item] + 1, 0).astype(np.uint32)
