"""Material textures in `texture_2d_array`s, one per size class and colour space, since WebGPU has no bindless textures.

A texture is a number for the shader: layer, class and wrap modes packed into 32 bits (`packed_reference`).
"""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import wgpu

from ..gpu.bindings import Binding, sampler, texture
from ..gpu.device import Device, DeviceError
from ..gpu.limits import DEFAULT_LIMITS
from ..scene.materials import Image, Texture
from .mipmaps import mip_chain, size_class

NO_TEXTURE = 0
_WRAPS = {"repeat": 0, "mirrored_repeat": 1, "clamp_to_edge": 2}
_FORMATS = {True: "rgba8unorm-srgb", False: "rgba8unorm"}


class TextureArrays:
    """All images that the materials use, on the device.

    uses: pairs (texture, whether its colours are sRGB). `classes` are the (edge, srgb) pairs that occur: shaders are
    made for these alone, so that a scene whose textures have one size pays for no choice.
    """

    def __init__(self, device: Device, uses: Iterable[tuple[Texture, bool]]):
        self._places: dict[tuple[int, bool], tuple[int, int]] = {}
        members: dict[tuple[int, bool], list[Image]] = {}
        for used, srgb in uses:
            key = (id(used.image), srgb)
            if key not in self._places:
                layers = members.setdefault((size_class(used.image), srgb), [])
                self._places[key] = (size_class(used.image), len(layers))
                layers.append(used.image)
        self.classes = sorted(members)
        self.resources: dict[str, Any] = {
            array_name(*key): _make_array(device, key[0], key[1], members[key]) for key in self.classes
        }
        self.resources["material_sampler"] = device.wgpu.create_sampler(
            mag_filter="linear", min_filter="linear", mipmap_filter="linear",
            address_mode_u="repeat", address_mode_v="repeat",
        )  # fmt: skip

    def bindings(self) -> list[Binding]:
        arrays = [texture(array_name(*key), "float", "2d-array") for key in self.classes]
        return [*arrays, sampler("material_sampler")]

    def packed_reference(self, used: Texture | None, srgb: bool) -> int:
        """layer | class << 8 | wrap u << 12 | wrap v << 14 | 1 << 31, or NO_TEXTURE; class counts within `srgb`."""
        if used is None:
            return NO_TEXTURE
        edge, layer = self._places[(id(used.image), srgb)]
        index = [e for e, s in self.classes if s == srgb].index(edge)
        return layer | index << 8 | _WRAPS[used.wrap[0]] << 12 | _WRAPS[used.wrap[1]] << 14 | 1 << 31


def array_name(edge: int, srgb: bool) -> str:
    return f"{'srgb' if srgb else 'linear'}_{edge}"


def _make_array(device: Device, edge: int, srgb: bool, images: list[Image]) -> Any:
    if len(images) > DEFAULT_LIMITS["max-texture-array-layers"]:
        raise DeviceError(
            f"The scene has {len(images)} textures of about {edge} pixels; one array holds "
            f"{DEFAULT_LIMITS['max-texture-array-layers']}. Merge some or turn textures off."
        )
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    levels = edge.bit_length()
    array = device.texture(
        "material textures", (edge, edge, len(images)), _FORMATS[srgb], usage=usage, mip_levels=levels
    )
    with ThreadPoolExecutor(max_workers=4) as pool:
        for layer, chain in enumerate(pool.map(lambda image: mip_chain(image, edge, srgb), images)):
            for level, pixels in enumerate(chain):
                device.write_layer(array, pixels, layer=layer, level=level)
    return array
