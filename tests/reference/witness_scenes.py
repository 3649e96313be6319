"""Scenes on which the path tracer and Mitsuba have to agree, each with a camera and a small size.

Faces are flat where models have smooth normals: at silhouettes of smooth normals renderers differ by convention, not in
their transport of light. No area light is seen by a camera: octolux does not show them, Mitsuba does.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import radians
from pathlib import Path

import numpy as np
import pytest

from octolux.data import data_folder
from octolux.scene.builtin.cornell_box import cornell_box
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.images.environment_maps import load_environment_map
from octolux.scene.lights import AreaLight, DirectionalLight
from octolux.scene.load import load_scene
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance, Mesh
from octolux.scene.scene import Scene


@dataclass(frozen=True)
class View:
    """size: (width, height), whole blocks of 8 pixels.  glossy: has materials that are not Lambertian."""

    scene: Scene
    camera: Camera
    size: tuple[int, int]
    glossy: bool = False


def cornell_point() -> View:
    scene = replace(cornell_box(), tracks=[])
    return View(scene, scene.cameras[0], (64, 48))


LAMP = AreaLight(
    corners=((-0.4, 1.9, 1.7), (0.4, 1.9, 1.7), (0.4, 1.4, 1.8), (-0.4, 1.4, 1.8)), radiance=(80.0, 60.0, 40.0),
    name="lamp",
)  # fmt: skip
"""Before the open side of the box, above the camera's sight: Mitsuba would show it."""

DOWNWARDS = Camera.look_at((0.0, 1.1, 3.2), (0.0, 0.45, -0.2), vertical_fov=radians(32.0), name="downwards")


def cornell_area() -> View:
    return View(replace(cornell_box(), tracks=[], lights=[LAMP]), DOWNWARDS, (64, 48))


def cornell_glow() -> View:
    """A black plate below the ceiling whose underside glows: geometry in both programs."""
    box = cornell_box()
    glow = Material(name="glow", base_color=(0.0, 0.0, 0.0), specular=0.0, emissive=(80.0, 60.0, 40.0))
    plate = quad([(-0.25, 1.9, -0.25), (0.25, 1.9, -0.25), (0.25, 1.9, 0.25), (-0.25, 1.9, 0.25)], material=3)
    scene = replace(box, tracks=[], lights=[], materials=[*box.materials, glow], meshes=[*box.meshes, plate],
                    instances=[*box.instances, Instance(4, name="plate")])  # fmt: skip
    return View(scene, DOWNWARDS, (64, 48))


def cornell_glossy() -> View:
    """Walls and floor of plastic, a block of metal, one of polished plastic."""
    box = cornell_box()
    walls = [replace(m, specular=1.0, roughness=0.5) for m in box.materials]
    metal = Material(name="metal", base_color=(0.95, 0.7, 0.4), metallic=1.0, roughness=0.2)
    plastic = Material(name="plastic", base_color=(0.2, 0.3, 0.8), roughness=0.3)
    tall = replace(box.meshes[3], material=3, name="tall block")
    short = replace(box.meshes[3], material=4, name="short block")
    instances = [*box.instances[:3], replace(box.instances[3], mesh=4), box.instances[4]]
    scene = replace(box, tracks=[], lights=[LAMP], materials=[*walls, metal, plastic],
                    meshes=[*box.meshes[:3], tall, short], instances=instances)  # fmt: skip
    return View(scene, DOWNWARDS, (64, 48), glossy=True)


def sponza_sun() -> View:
    """The Dabrovic Sponza without its textures, in the sun that ground-truth/sponza_sunpoint.json names."""
    model = _data("scenes/dabrovic-sponza/sponza.obj")
    facts = json.loads(_data("ground-truth/sponza_sunpoint.json").read_text())
    scene = load_scene(model)
    plain = [Material(name=m.name, base_color=m.base_color, specular=0.0, double_sided=True) for m in scene.materials]
    light = facts["lights"][0]
    sun = DirectionalLight(direction=light["direction_of_travel"], illuminance=light["irradiance_W_per_m2"])
    scene = replace(scene, materials=plain, meshes=[flat(m) for m in scene.meshes], lights=[sun],
                    environment=Environment())  # fmt: skip
    view = facts["camera"]
    camera = Camera.look_at(view["look_from"], view["look_at"], vertical_fov=radians(view["vfov_deg"]))
    return View(scene, camera, (64, 48))


def bunny_environment() -> View:
    """The Stanford bunny, brushed metal, on a plastic floor by the sea."""
    scene = load_scene(_data("scenes/stanford-bunny/bun_zipper.ply"))
    low, high = scene.bounds()
    middle, reach = (low + high) / 2, float((high - low).max())
    ground = [(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)]
    floor = quad(np.array([middle[0], low[1], middle[2]]) + 2.0 * reach * np.array(ground), material=1)
    bronze = Material(name="bronze", base_color=(0.8, 0.5, 0.3), metallic=1.0, roughness=0.4, double_sided=True)
    plastic = Material(name="plastic", base_color=(0.5, 0.5, 0.5), roughness=0.5, double_sided=True)
    file = _data("scenes/env/spiaggia_di_mondello_1k.hdr")
    image = load_environment_map(file, 1.0, file, "environment", [])
    scene = replace(
        scene, materials=[bronze, plastic], meshes=[*(replace(flat(m), material=0) for m in scene.meshes), floor],
        instances=[*scene.instances, Instance(len(scene.meshes), name="floor")], lights=[],
        environment=Environment(image=image, rotation=0.7),
    )  # fmt: skip
    eye = middle + reach * np.array([0.3, 0.5, 1.7])
    return View(scene, Camera.look_at(eye, middle, vertical_fov=radians(40.0)), (64, 48), glossy=True)


VIEWS: dict[str, Callable[[], View]] = {
    "cornell-point": cornell_point, "cornell-area": cornell_area,
    "cornell-glow": cornell_glow, "cornell-glossy": cornell_glossy,
    "sponza-sun": sponza_sun, "bunny-environment": bunny_environment,
}  # fmt: skip


def flat(mesh: Mesh) -> Mesh:
    """The mesh with the normals of its faces; triangles without area are left out."""
    corners = mesh.positions[mesh.indices]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1)
    kept = length > 0
    flat_normals = np.repeat(normals[kept] / length[kept, None], 3, axis=0)
    vertices = mesh.indices[kept].ravel()
    return Mesh(
        positions=mesh.positions[vertices], normals=flat_normals, uvs=mesh.uvs[vertices],
        tangents=mesh.tangents[vertices], indices=np.arange(len(vertices), dtype=np.uint32).reshape(-1, 3),
        material=mesh.material, name=mesh.name,
    )  # fmt: skip


def _data(name: str) -> Path:
    path = data_folder() / name
    if not path.exists():
        pytest.skip("needs OCTOLUX_DATA")
    return path
