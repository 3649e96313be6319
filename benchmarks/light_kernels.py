"""Direct light on the device against its float64 version."""

from __future__ import annotations

import numpy as np

from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.simulator import brdf
from octolux.simulator.direct import radiance

from .lab import device
from .registry import at_most, figure

# Steps of what the G-buffer stores: 1/65535 for colours, 1/255 for roughness and metallic.
_ROUGHNESS = (51 / 255, 102 / 255, 204 / 255, 1.0)
_METALLIC = (0.0, 51 / 255, 1.0, 0.0)
_LIGHTS = [
    DirectionalLight(direction=(0.3, -1.0, 0.2), illuminance=(3.0, 2.0, 1.0)),
    PointLight(position=(0.4, 1.1, -0.5), intensity=(1.0, 2.0, 3.0)),
    SpotLight(
        position=(-0.8, 1.5, 0.6), direction=(0.5, -1.0, -0.3), intensity=(5.0, 4.0, 6.0), inner_angle=0.2,
        outer_angle=0.8,
    ),
]  # fmt: skip


def materials() -> list[Material]:
    """Matt and glossy, dielectric and metal."""
    rng = np.random.default_rng(1)
    colors = rng.integers(6553, 65536, (4, 3)) / 65535
    factors = zip(colors, _ROUGHNESS, _METALLIC, strict=True)
    return [Material(base_color=tuple(c), roughness=r, metallic=m) for c, r, m in factors]


def tiles() -> Scene:
    """A floor of four tiles that nothing shadows, each of another material, under a light of each kind."""
    places = [(-1.0, -1.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 0.0)]
    meshes = [
        quad([(x, 0, z + 1), (x + 1, 0, z + 1), (x + 1, 0, z), (x, 0, z)], material=i)
        for i, (x, z) in enumerate(places)
    ]
    return Scene(
        meshes=meshes, instances=[Instance(i) for i in range(4)], materials=materials(), lights=_LIGHTS, exposure=0.0,
        cameras=[Camera.look_at((0.9, 1.4, 1.6), (0.0, 0.0, 0.0), vertical_fov=0.9)],
    )  # fmt: skip


@figure("kernel_direct_light", group="kernels", unit="relative", bound=at_most(1e-4))
def kernel_direct_light() -> float:
    """The glTF BRDF under three kinds of light on four materials: difference over the pixel's largest channel."""
    scene = tiles()
    picture = Renderer(scene, "none", size=(96, 64), device=device()).render()
    layers = picture.layers
    tile = np.maximum(layers["object_id"].astype(int) - 1, 0)
    made = scene.materials
    surface = brdf.surface(
        np.array([m.base_color for m in made])[tile], np.array([m.metallic for m in made])[tile],
        np.array([m.roughness for m in made])[tile],
    )  # fmt: skip
    eye = scene.cameras[0].position
    expected = sum(radiance(light, layers["position"], layers["normal"], eye, surface) for light in scene.lights)
    error = np.abs(layers["direct"] - expected).max(axis=-1) / np.where(picture.mask, expected.max(axis=-1), 1.0)
    return float(error[picture.mask].max())
