"""Settings of voxel-cones that change what light does, as pictures."""

from __future__ import annotations

import numpy as np
from gpu_tools import scene_of
from test_voxel_cones_pictures import FLOOR, PAINT, from_above, renderer, technique

from octolux.scene.builtin.shapes import quad
from octolux.scene.lights import DirectionalLight
from octolux.scene.scene import Scene

SUN = DirectionalLight(direction=(-1.0, 0.0, 0.0), illuminance=(5.0, 6.0, 7.0))


def floor_and_walls(*places: float) -> Scene:
    """A floor, dark from the sun, and lit walls 0.5 m high across it at x."""
    walls = [quad([(x, 0, 1), (x, 0, -1), (x, 0.5, -1), (x, 0.5, 1)]) for x in places]
    return scene_of([FLOOR, *walls], [PAINT], lights=[SUN])


def test_a_box_of_its_own(device):
    """Voxels are as small as it is, and what is outside is neither lit, but for what the filter's window of 8 pixels
    takes along, nor there: as if the scene ended at the box."""
    camera, given = from_above(2.0, 2.0), {"box": "-0.5 -0.1 -0.5 0.5 0.6 0.5", "size": (96, 96)}
    whole = renderer(device, floor_and_walls(-0.9), **given)
    lost = whole.render(camera).layers["irradiance"]
    assert np.isclose(technique(whole).octree.grid.cell_size, 1.0 / (2**6 - 3)) and not lost.any()
    made = renderer(device, floor_and_walls(-0.4, -0.9), **given)
    found = made.render(camera).layers["irradiance"]
    alone = renderer(device, floor_and_walls(-0.4), **given).render(camera)
    x = np.abs((np.arange(96) + 0.5) / 48.0 - 1.0)
    assert (found[40:56, x < 0.35].min(axis=-1) > 0.0).all() and not found[:, x > 0.53 + 8 / 48].any()
    np.testing.assert_array_equal(found, alone.layers["irradiance"])
