"""Meshes from arrays, and scenes from trimesh's objects."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image as Pillow

import octolux
from octolux.simulator.tonemap import srgb_decode

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
FACES = [(0, 1, 2), (0, 2, 3)]


@pytest.mark.covers("model NumPy arrays")
@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64, np.int8, np.int64, np.uint8])
@pytest.mark.parametrize("index", [np.uint8, np.int32, np.uint32, np.int64, np.uint64, np.float64])
def test_any_numeric_type(kind, index):
    mesh = octolux.Mesh.from_arrays(np.array(SQUARE, kind), np.array(FACES, index), name="square", material=3)
    assert mesh.positions.dtype == np.float32 and mesh.indices.dtype == np.uint32
    np.testing.assert_array_equal(mesh.positions[mesh.indices], np.array(SQUARE)[np.array(FACES)])
    np.testing.assert_array_equal(mesh.normals, [(0, 0, 1)] * len(mesh.normals))
    assert (mesh.name, mesh.material, mesh.colors) == ("square", 3, None)


@pytest.mark.covers("model NumPy arrays")
def test_arrays_are_copied():
    points = np.array(SQUARE, np.float32)
    mesh = octolux.Mesh.from_arrays(points, FACES, normals=points + np.array((0, 0, 2)))
    points[:] = 9
    assert mesh.positions.max() == 1
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, rtol=1e-6)


@pytest.mark.covers("model NumPy arrays")
def test_lists_flat_indices_and_three_channels():
    uvs = np.array(SQUARE)[:, :2]
    mesh = octolux.Mesh.from_arrays(SQUARE, [0, 1, 2, 0, 2, 3], colors=[(0.5, 0.25, 1.0)] * 4, uvs=uvs)
    np.testing.assert_array_equal(mesh.colors, [(0.5, 0.25, 1.0, 1.0)] * 4)
    np.testing.assert_array_equal(mesh.uvs, mesh.positions[:, :2])
    np.testing.assert_allclose(mesh.tangents[:, :3], [(1, 0, 0)] * 4, atol=1e-6)


@pytest.mark.covers("model NumPy arrays")
def test_whole_numbers_of_colour_are_srgb_and_alpha_is_not():
    mesh = octolux.Mesh.from_arrays(SQUARE, FACES, colors=np.array([(188, 0, 255, 51)] * 4, np.uint8))
    expected = [float(srgb_decode(np.array(188 / 255))), 0.0, 1.0, 0.2]
    np.testing.assert_allclose(mesh.colors, [expected] * 4, rtol=1e-6)


MISTAKES = {
    "positions must be numbers of the shape (n, 3)": {"positions": [(0, 0), (1, 0), (1, 1)]},
    "positions must be numbers": {"positions": [("a", "b", "c")]},
    "positions is no array": {"positions": [(0, 0, 0), (1, 0)]},
    "row 1 is [1.0, nan, 0.0]": {"positions": [(0, 0, 0), (1, float("nan"), 0), (1, 1, 0), (0, 1, 0)]},
    "row 0 is [1e+300": {"positions": [(1e300, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]},
    "indices must be from 0 to 3, one is 4": {"indices": [(0, 1, 4)]},
    "one is -1": {"indices": [(0, 1, -1)]},
    "cut polygons in triangles": {"indices": [(0, 1, 2, 3)]},
    "whole numbers, got float64": {"indices": [(0, 1, 2.5)]},
    "normals must be of the shape (4, 3), one row": {"normals": [(0, 0, 1)]},
    "uvs must be numbers of the shape (4, 2)": {"uvs": SQUARE},
    "colors must be numbers of the shape (4, 3) or (4, 4)": {"colors": [0.5] * 4},
    "colors must not be negative": {"colors": [(-1.0, 0, 0)] * 4},
}


@pytest.mark.covers("model NumPy arrays", broken=True)
@pytest.mark.parametrize("text", MISTAKES)
def test_mistakes_name_the_array(text):
    with pytest.raises(octolux.OctoluxError) as caught:
        octolux.Mesh.from_arrays(**{"positions": SQUARE, "indices": FACES, **MISTAKES[text]})
    assert text in str(caught.value)


@pytest.mark.covers("model NumPy arrays")
def test_a_scene_of_one_mesh():
    scene = octolux.Scene.from_arrays(SQUARE, FACES, material=octolux.Material(base_color=(1, 0, 0)), name="s")
    assert scene.triangle_count == 2
    assert scene.materials[0].base_color == (1, 0, 0)
    np.testing.assert_array_equal(scene.bounds(), [(0, 0, 0), (1, 1, 0)])


@pytest.fixture
def trimesh():
    return pytest.importorskip("trimesh")


@pytest.mark.covers("model trimesh objects")
def test_a_trimesh_box_by_load(trimesh):
    scene = octolux.load(trimesh.creation.box(extents=(1, 2, 3)))
    assert scene.triangle_count == 12
    np.testing.assert_allclose(scene.bounds(), [(-0.5, -1, -1.5), (0.5, 1, 1.5)])
    normals = np.abs(scene.meshes[0].normals)
    np.testing.assert_array_equal(normals.max(axis=1), 1)  # edges are kept
    assert scene.materials[0].base_color == (0.6, 0.6, 0.6)


@pytest.mark.covers("model trimesh objects")
def test_graph_units_camera_and_what_is_no_mesh(trimesh):
    box = trimesh.creation.box()
    source, moved = trimesh.Scene(), trimesh.transformations.translation_matrix((5, 0, 0))
    source.add_geometry(box, node_name="a", geom_name="box", transform=moved)
    source.add_geometry(box, node_name="b", geom_name="box")
    source.add_geometry(trimesh.PointCloud([(0, 0, 0)]), node_name="dust")
    source.units = "millimeters"
    source.camera = trimesh.scene.Camera(name="c", fov=(60, 40), resolution=(60, 40))
    source.camera_transform = np.eye(4)
    scene = octolux.from_trimesh(source)
    assert len(scene.meshes) == len({i.mesh for i in scene.instances}) <= 2
    places = {i.name: i.transform for i in scene.instances}
    np.testing.assert_allclose(places["a"][:3, 3], (0.005, 0, 0))
    assert scene.triangle_count == 24
    assert scene.cameras[0].vertical_fov == pytest.approx(np.radians(40))
    assert len(scene.warnings) == 1 and "PointCloud" in scene.warnings[0]


@pytest.mark.covers("model trimesh objects")
def test_vertex_and_face_colours(trimesh):
    box = trimesh.creation.box()
    box.visual.vertex_colors = [188, 188, 188, 255]
    mesh = octolux.load(box).meshes[0]
    np.testing.assert_allclose(mesh.colors[:, 0], srgb_decode(np.array(188 / 255)), rtol=1e-6)
    box = trimesh.creation.box()
    box.visual.face_colors[:] = [0, 0, 0, 255]
    box.visual.face_colors[7] = [255, 0, 0, 255]
    scene = octolux.load(box)
    mesh = scene.meshes[0]
    red = np.flatnonzero(mesh.colors[mesh.indices][:, :, 0].min(axis=1) == 1)
    assert red.tolist() == [7]
    np.testing.assert_allclose(mesh.normals[mesh.indices[7]], [box.face_normals[7]] * 3, atol=1e-6)
    assert scene.materials[0].base_color == (1.0, 1.0, 1.0)


def textured(trimesh, material):
    uv = [(0, 0), (1, 0), (1, 1), (0, 1)]
    visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return octolux.load(trimesh.Trimesh(SQUARE, FACES, visual=visual, process=False))


@pytest.mark.covers("model trimesh objects")
def test_pbr_material(trimesh):
    picture = Pillow.new("RGB", (4, 2), (1, 2, 3))
    made = trimesh.visual.material.PBRMaterial(
        name="m", baseColorFactor=[51, 102, 255, 128], baseColorTexture=picture, metallicFactor=0.25,
        roughnessFactor=0.5, emissiveFactor=[1.0, 2.0, 3.0], normalTexture=picture, alphaMode="MASK", alphaCutoff=0.3,
        doubleSided=True,
    )  # fmt: skip
    scene = textured(trimesh, made)
    m = scene.materials[0]
    assert (m.name, m.metallic, m.roughness, m.alpha_mode, m.alpha_cutoff, m.double_sided) == (
        "m", 0.25, 0.5, "mask", 0.3, True)  # fmt: skip
    assert m.base_color == pytest.approx((0.2, 0.4, 1.0)) and m.alpha == pytest.approx(128 / 255)
    assert m.emissive == (1.0, 2.0, 3.0)
    assert m.base_color_texture.image is m.normal_texture.image
    assert m.base_color_texture.image.pixels[0, 0].tolist() == [1, 2, 3, 255]
    mesh = scene.meshes[0]
    corner = np.argmin(np.linalg.norm(mesh.positions - (1, 0, 0), axis=1))
    np.testing.assert_array_equal(mesh.uvs[corner], (1, 1))


@pytest.mark.covers("model trimesh objects")
def test_simple_material(trimesh):
    made = trimesh.visual.material.SimpleMaterial(diffuse=[51, 102, 255, 255], specular=[0, 0, 0, 255], glossiness=6.0)
    m = textured(trimesh, made).materials[0]
    assert m.base_color == pytest.approx((0.2, 0.4, 1.0))
    assert (m.specular, m.roughness) == (0.0, pytest.approx(0.5**0.5))


@pytest.mark.covers("model trimesh objects", broken=True)
def test_impossible_units_and_sizes(trimesh):
    source = trimesh.Scene(trimesh.creation.box())
    source.units = "ells and a half"
    with pytest.raises(octolux.SceneError, match="ells"):
        octolux.load(source)
    huge = trimesh.Scene()
    huge.add_geometry(trimesh.creation.box(), transform=trimesh.transformations.scale_matrix(1e18))
    with pytest.raises(octolux.SceneError, match=r"1e\+15 m"):
        octolux.load(huge)


@pytest.mark.covers("model trimesh objects", broken=True)
def test_other_objects_are_refused(trimesh):
    for thing in (42, None, trimesh.PointCloud([(0, 0, 0)])):
        with pytest.raises(octolux.SceneError, match="nothing that a scene can be loaded from"):
            octolux.load(thing)
        with pytest.raises(octolux.SceneError, match="neither"):
            octolux.from_trimesh(thing)
