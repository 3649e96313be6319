"""Debug views of a rendered frame of voxel-cones, by their names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import read_buffer, scene_of
from test_voxel_cones_motion import room
from test_voxel_cones_pictures import FLOOR, PAINT, SIZE, from_above, renderer, spot, technique

from octolux.scene.errors import OctoluxError
from octolux.scene.lights import DirectionalLight
from octolux.scene.load import load_scene
from octolux.techniques.voxel_cones.views.views import WAYS


@pytest.fixture(scope="module")
def box(device):
    made = renderer(device, load_scene("cornell-box"))
    assert made.technique.debug_views()  # the names are there before a frame
    with pytest.raises(OctoluxError, match="before a frame"):
        made.technique.debug_views()["nodes"]
    return made.render(), made.technique.debug_views()


def test_every_view_can_be_made(box):
    """The numbers are arrays of rows, all others pictures of the frame's size. Nothing is seen where there is none: no
    box glows, and nothing that is seen faces -z and is lit."""
    _, views = box
    numbers = {"fragments", "nodes", "updates", "cones", *(f"voxels:{level}" for level in range(6))}
    assert numbers < set(views)
    for name in views:
        view = views[name]
        assert views.is_picture(name) == (name not in numbers), name
        if name in numbers:
            assert len(view) and view.dtype != np.float32, name
        else:
            assert view.dtype == np.float32 and view.shape == (SIZE[1], SIZE[0], 3), name
            assert view.min() >= 0.0 and view.max() <= 1.0, name
            assert view.any() or name.endswith((":emission", "light-z")), name


def test_drawn_values_are_those_of_the_voxels(box):
    """Of a level's picture the colours are values of its voxels, times one of the four shades of sides."""
    _, views = box
    for level, way in ((1, 2), (3, 4)):
        drawn = views[f"voxels:{level}:opacity{WAYS[way]}"]
        values = np.unique(views[f"voxels:{level}"]["facing"][:, way])
        shades = (values[:, None] * np.array([0.5, 0.6, 0.8, 1.0])).astype(np.float32).ravel()
        assert np.abs(drawn.reshape(-1, 1) - shades).min(axis=1).max() < 1e-6 and drawn.max() > 0.2


def test_red_is_left_and_green_right(box):
    """Where a wall's colour is plain in the picture it is so in the voxels, but at its edges."""
    picture, views = box
    albedo, drawn = picture.layers["albedo"], views["voxels:0:albedo"]
    for channel, side in ((0, slice(0, 16)), (1, slice(16, 32))):
        plain = albedo[..., channel] > 2.0 * np.delete(albedo, channel, axis=2).max(axis=2)
        assert plain.sum() > 20 and not np.delete(plain, np.r_[side], axis=1).any()
        assert (drawn[plain].argmax(axis=-1) == channel).mean() > 0.8


def test_normals_are_of_the_side_that_is_seen(device):
    """Walls whose other side voxels have too are shown with the normal of this one."""
    made = renderer(device, load_scene("cornell-box"))
    picture = made.render()
    normals = picture.layers["normal"]
    walls = picture.mask & (np.abs(normals).max(axis=-1) > 0.999)
    shown, colour = made.technique.debug_views()["voxels:0:normal"][walls], 0.5 + 0.5 * normals[walls]
    alike = np.cross(shown, colour) / np.linalg.norm(colour, axis=-1, keepdims=True)  # each side is shaded otherwise
    straight = (np.abs(alike) < 1.0 / 255).all(axis=-1) & shown.any(axis=-1)
    assert walls.sum() > 100 and straight.mean() > 0.9, "but for voxels in corners"


def test_nodes_and_updates(device):
    """In the first frame all nodes with bricks are made anew, then those near a light that moves; then none."""
    scene, camera = scene_of([FLOOR], [PAINT], lights=[spot(-0.5)]), from_above(2.0, 2.0)
    made, counts = renderer(device, scene, depth=7), []
    for place in (-0.5, -0.45, -0.45):
        made.scene = replace(scene, lights=[spot(place)])
        made.render(camera)
        views = made.technique.debug_views()
        counts.append(len(views["updates"]))
        drawn = views["updates:0"]
        seen = drawn[drawn.any(axis=-1)]
        orange = seen[:, 0] > seen[:, 2]
        assert orange.any() == bool(counts[-1]) and orange.all() == (len(counts) == 1)
    nodes, octree = made.technique.debug_views()["nodes"], technique(made).octree
    ways = read_buffer(device, octree.bricks.ways.resource, np.uint32)[: len(nodes)]
    assert counts[0] == np.count_nonzero(ways & 63) and 0 < counts[1] < 0.4 * counts[0] and counts[2] == 0
    assert set(map(tuple, views["updates"])) <= set(map(tuple, nodes)) and len(nodes) == octree.octree.counts.nodes
    assert nodes[0].tolist() == [6, 0, 0, 0] and (nodes[:, 1:].max(axis=1) < 2 ** (6 - nodes[:, 0])).all()


def test_nodes_are_shown_on_the_surfaces_in_them(device):
    """Every surface has a node, and pixels of one node one hue: but for those within rounding of a cell's face."""
    made = renderer(device, load_scene("cornell-box"))
    picture, grid = made.render(), technique(made).octree.grid
    at = (picture.layers["position"] - np.array(grid.origin)) / (8.0 * grid.cell_size)
    clear = picture.mask & (np.abs(at - np.round(at)) > 1e-4).all(axis=-1)
    drawn = made.technique.debug_views()["nodes:2"]
    assert clear.sum() > 200 and drawn[clear].any(axis=-1).all() and not drawn[~picture.mask].any()
    hues = drawn / np.maximum(drawn.max(axis=-1, keepdims=True), 1e-6)
    cells = np.floor(at).astype(int)
    of_cell = {tuple(cell): hues[y, x] for (y, x), cell in zip(np.argwhere(clear), cells[clear], strict=True)}
    expected = np.array([of_cell[tuple(cell)] for cell in cells[clear]])
    np.testing.assert_allclose(hues[clear], expected, atol=1e-6)
    assert len(np.unique(np.round(expected, 4), axis=0)) == len(of_cell) > 20


def test_cones_of_a_pixel_by_its_name(box):
    _, views = box
    middle, there = views["cones"], views[f"cones:{SIZE[0] // 2}:{SIZE[1] // 2}"]
    assert np.array_equal(middle, there) and not np.array_equal(middle, views["cones:20:20"])
    for name, message in (("cones:32:3", "0:0 to 31:23, not 32:3"), ("cones:0:0", "0:0 sees no surface")):
        with pytest.raises(OctoluxError, match=message):
            views[name]


def test_where_light_of_lobes_comes_from(device):
    """Of a floor under a sun straight overhead: up, and all of it. Axial voxels do not know."""
    scene = scene_of([FLOOR], [PAINT], lights=[DirectionalLight(direction=(0.0, -1.0, 0.0), illuminance=(1.0,) * 3)])
    made, camera = renderer(device, scene, representation="lobes"), from_above(2.0, 1.0)
    made.render(camera)
    views = made.technique.debug_views()
    found = views["voxels:1"]
    lit = found["light"].any(axis=(1, 2))
    # A moment has 8 bits of its largest part.
    np.testing.assert_allclose(found["comes_from"][lit], np.tile([0.0, 1.0, 0.0], (lit.sum(), 1)), atol=2.0**-7)
    np.testing.assert_allclose(views["voxels:1:comes_from"][12, 16], (0.5, 1.0, 0.5), atol=2.0**-7)
    assert lit.any() and "voxels:1:comes_from" not in renderer(device, scene).technique.debug_views()


@pytest.mark.parametrize("wrong", ["voxels:0:albedos", "voxels:6:normal", "voxels:1:albedo", "cones:1", "cones:a:b"])
def test_unknown_views_are_refused(box, wrong):
    with pytest.raises(OctoluxError, match=f"no debug view '{wrong}'. Did you mean"):
        box[1].is_picture(wrong)


def test_what_moves_is_seen_among_what_is_static(device):
    """Voxels, nodes that hold any, and pictures are those of a fresh renderer, where everything is static."""
    made = renderer(device, room())
    made.render()
    before = made.technique.debug_views()["voxels:0"]
    made.scene = room((0.3, 0.4, 0.2))
    made.render()
    fresh = renderer(device, made.scene)
    fresh.render()
    moved, still = (one.technique.debug_views() for one in (made, fresh))
    assert len(technique(made).parts.octrees) == 2 and len(technique(fresh).parts.octrees) == 1
    for level in range(6):
        found, expected = (np.sort(views[f"voxels:{level}"], order="cell") for views in (moved, still))
        for name in found.dtype.names:
            np.testing.assert_array_equal(found[name], expected[name], err_msg=f"{name} on level {level}")
    for name in ("voxels:0:albedo", "voxels:1:light", "voxels:3:normal", "fragments:drawn"):
        np.testing.assert_array_equal(moved[name], still[name], err_msg=name)
    assert len(before) != len(moved["voxels:0"]) or not np.array_equal(before, moved["voxels:0"])
    assert set(map(tuple, still["nodes"])) <= set(map(tuple, moved["nodes"]))
    assert 0 < len(moved["updates"]) < len(moved["nodes"])
