"""voxel-cones while things move, bend, glow, come and go: every picture is that of a fresh renderer, to the bit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from gpu_tools import read_buffer, small_settings

from octolux.gpu.device import Device
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box
from octolux.scene.lights import PointLight
from octolux.scene.load import load_scene
from octolux.scene.materials import Material
from octolux.scene.meshes import Deformable, Instance, Mesh
from octolux.scene.motion.deformation import deformed
from octolux.scene.scene import Scene
from octolux.techniques.voxel_cones.technique import VoxelCones
from octolux.techniques.voxel_cones.voxels.structure import VoxelOctree

SIZE = (32, 24)
PAINT = Material(base_color=(0.7, 0.5, 0.2), double_sided=True, specular=0.5, roughness=0.3)
LAMP = PointLight(position=(0.1, 1.7, 0.2), intensity=(5.0, 6.0, 7.0))
START = (-0.6, 0.02, 0.5)  # on the floor, a fraction of a voxel from the wall


def placed(position) -> np.ndarray:
    transform = np.eye(4)
    transform[:3, 3] = position
    return transform


def cube() -> Mesh:
    """With two joints, of which the second has the upper vertices."""
    mesh = box((-0.15, 0.0, -0.15), (0.15, 0.5, 0.15))
    upper = mesh.positions[:, 1] > 0.25
    weights = np.stack([~upper, upper], axis=1).astype(np.float32)
    base = Deformable(
        positions=mesh.positions, normals=mesh.normals, tangents=mesh.tangents, weights=weights,
        joints=np.tile(np.array([0, 1], np.uint16), (len(upper), 1)),
    )  # fmt: skip
    return replace(mesh, deformable=base)


def room(position=START, mesh: Mesh | None = None, material: Material = PAINT, lamp: PointLight = LAMP) -> Scene:
    """The Cornell box with a cube in it."""
    scene = load_scene("cornell-box")
    mesh = replace(mesh or MESH, material=len(scene.materials))
    scene.materials.append(material)
    scene.meshes.append(mesh)
    scene.instances.append(Instance(len(scene.meshes) - 1, placed(position), name="cube"))
    scene.lights = [lamp]
    return scene


MESH = cube()


def bent(across: float) -> Mesh:
    return deformed(MESH, (), np.stack([np.eye(4), placed((across, 0.0, 0.1))]))


def renderer(device, scene: Scene, **settings: Any) -> Renderer:
    return Renderer(
        scene, "voxel-cones", settings={"depth": 6, "bounces": 1, **settings}, size=SIZE, device=device, exposure=0.0,
        default_light=False, frame_settings=small_settings(sky_lights=0, emitter_lights=2),
    )  # fmt: skip


def technique(made: Renderer) -> VoxelCones:
    assert isinstance(made.technique, VoxelCones)
    return made.technique


def scenes(base: Scene, **changes: Any) -> Scene:
    """`base`, whose unchanged elements stay the same objects, with some of the cube's things replaced."""
    made = replace(base, **{name: list(getattr(base, name)) for name in ("meshes", "instances", "materials", "lights")})
    for name, value in changes.items():
        if value is not None:
            getattr(made, name)[-1] = value
    return made


def steps(kind: str, base: Scene) -> list[Scene]:
    """Two scenes that differ from `base` by how the cube is."""
    if kind == "moved":
        places = ((-0.2, 0.7, 0.1), (0.55, 0.9, -0.5))  # in the air, and into the tall block
        return [scenes(base, instances=replace(base.instances[-1], transform=placed(p))) for p in places]
    if kind == "skinned":
        return [scenes(base, meshes=replace(bent(x), material=base.meshes[-1].material)) for x in (0.2, -0.15)]
    if kind == "glows":
        return [scenes(base, materials=replace(PAINT, emissive=(e, 0.2 * e, 0.0))) for e in (50.0, 90.0)]
    return [scenes(base, materials=replace(PAINT, base_color=(c, 0.1, 0.9), alpha=c, alpha_mode="blend"))
            for c in (0.9, 0.4)]  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "settings"),
    [("moved", {}), ("moved", {"bounces": 3, "resolution": 1}), ("moved", {"bounces": 2, "representation": "lobes"}),
     ("skinned", {}), ("glows", {}), ("painted", {})],
)
def test_pictures_are_those_of_a_fresh_renderer(device, kind, settings):
    """Also when the lamp moves beside; and back where it was, nothing is left."""
    base = room()
    made = renderer(device, base, **settings)
    before = made.render().radiance
    for number, scene in enumerate(steps(kind, base)):
        scene.lights = [replace(LAMP, position=(0.1 - 0.2 * number, 1.7, 0.2))]
        made.scene = scene
        picture = made.render().radiance
        assert not np.array_equal(picture, before)
        assert np.array_equal(picture, renderer(device, scene, **settings).render().radiance)
    made.scene = base
    assert np.array_equal(made.render().radiance, before)


def test_what_is_static_is_built_once_more(device, monkeypatch):
    """When the cube first moves; afterwards its octree stays as it is, but for light. What is still builds nothing."""
    built: list[VoxelOctree] = []
    plain = VoxelOctree.build
    monkeypatch.setattr(VoxelOctree, "build", lambda self, *a, **k: (built.append(self), plain(self, *a, **k))[1])
    base = room()
    made = renderer(device, base)
    for _ in range(2):
        made.render()
    static = technique(made).octree
    assert built == [static] and technique(made).parts.moving is None
    facing = None
    for step in range(4):
        made.scene = scenes(base, instances=replace(base.instances[-1], transform=placed((-0.2 * step, 0.3, 0.0))))
        for _ in range(2):
            made.render()
        moving = technique(made).parts.moving
        assert moving is not None and built[1:] == [static, *[moving] * (step + 1)]
        assert moving.octree.counts.nodes < 0.25 * static.octree.counts.nodes
        words = read_buffer(device, static.bricks.facing.resource, np.uint32)
        assert facing is None or np.array_equal(words, facing)
        facing = words


def test_what_moves_away_for_good(device):
    """It vanishes, and with it the second octree; another comes, and is static at first."""
    base = room()
    made = renderer(device, base)
    made.render()
    made.scene = moved = steps("moved", base)[0]
    made.render()
    made.scene = scenes(moved)
    del made.scene.instances[-1]
    gone = made.render().radiance
    assert technique(made).parts.moving is None
    assert np.array_equal(gone, renderer(device, made.scene).render().radiance)
    made.scene = scenes(made.scene)
    made.scene.instances.append(Instance(len(base.meshes) - 1, placed((0.0, 1.2, 0.0))))
    assert np.array_equal(made.render().radiance, renderer(device, made.scene).render().radiance)
    assert technique(made).parts.moving is None


def test_the_cube_of_voxels_stays(device):
    """While the cube moves in the room; outside there is one around everything, and back in the room the old one."""
    base = room()
    made = renderer(device, base)
    before, grids = made.render().radiance, [technique(made).octree.grid]
    for position in ((0.3, 0.3, 0.3), (0.0, 3.0, 0.0), START):
        made.scene = scenes(base, instances=replace(base.instances[-1], transform=placed(position)))
        after = made.render().radiance
        grids.append(technique(made).octree.grid)
        assert technique(made).parts.moving.grid == grids[-1]
        if position[1] > 2.0:
            assert np.array_equal(after, renderer(device, made.scene).render().radiance)
    assert grids[0] == grids[1] == grids[3] != grids[2]
    assert np.array_equal(after, before)


def test_a_scene_in_which_everything_has_moved(device):
    base = room()
    made = renderer(device, base)
    before = made.render().radiance
    made.scene = replace(base, instances=[
        replace(i, transform=placed((0.0, 0.1, 0.0)) @ i.transform) for i in base.instances
    ])  # fmt: skip
    assert np.array_equal(made.render().radiance, renderer(device, made.scene).render().radiance)
    made.scene = base
    assert np.array_equal(made.render().radiance, before)


def test_pools_say_how_full_they_are(device):
    """What is there fits, exactly where it was made for it; what moves has pools of its own."""
    scene = load_scene("cornell-box")
    made = renderer(device, scene)
    made.render()
    pools, counts = made.statistics()["pools"], technique(made).octree.octree.counts
    assert set(pools) == {f"static {name}" for name in ("leaves", "voxels", "nodes", "bricks")}
    assert pools["static nodes"]["used"] == counts.nodes and pools["static voxels"]["used"] == counts.voxels
    assert all(0 < pool["used"] <= pool["room"] <= pool["most"] for pool in pools.values())
    first, *others = scene.instances
    made.scene = replace(scene, instances=[replace(first, transform=first.transform + np.eye(4, k=3) * 0.01), *others])
    made.render()
    assert made.statistics()["pools"]["moving voxels"]["used"] > 0


def test_nothing_grows():
    """Neither memory nor the octree of what moves, while the cube and the lamp go round."""
    device, base = Device(), room()  # of others, things may be collected meanwhile
    made, held = renderer(device, base, bounces=2), []
    made.render()
    for k in range(24):
        angle = 2.0 * np.pi * (k % 6) / 6
        x, z = 0.5 * np.cos(angle), 0.5 * np.sin(angle)
        made.scene = scenes(base, instances=replace(base.instances[-1], transform=placed((x, 0.2, z))))
        made.scene.lights = [replace(LAMP, position=(-x, 1.5, z))]
        made.render()
        held.append((device.memory.total, *technique(made).parts.moving.pools().values()))
    assert held[12:18] == held[18:24]
