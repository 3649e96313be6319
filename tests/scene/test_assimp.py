"""PLY, STL, FBX, Collada and the other formats of assimp; and its crashes."""

from __future__ import annotations

import numpy as np
import pytest
from model_files import CORNERS, FILES, OFF, dae, fbx, ply

from octolux.scene.assimp import loader as assimp
from octolux.scene.assimp.scene import EXTENSIONS, WITHOUT_MATERIALS, load_assimp
from octolux.scene.errors import SceneError
from octolux.scene.load import LOADERS, load_scene
from octolux.simulator.tonemap import srgb_decode

# 3D Studio's formats are z up; assimp turns them, so that what faced +z faces +y.
TURNED = (".3ds", ".ase")
# Formats whose writers above give specular 0.02 and exponent 6: F0 of 0.04 * 0.5, roughness (2 / 8)^(1/4).
GLOSSY = (".fbx", ".dae", ".x", ".x3d", ".ms3d", ".ac")

KINDS = [pytest.param(kind, marks=pytest.mark.covers(f"model {kind}")) for kind in EXTENSIONS]


def save(folder, name: str, content: str | bytes):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def test_every_extension_has_a_file_here():
    assert set(FILES) == set(EXTENSIONS) <= set(LOADERS)


@pytest.mark.parametrize("kind", KINDS)
def test_a_square(kind, tmp_path):
    scene = load_scene(save(tmp_path, "square" + kind, FILES[kind]))
    assert scene.triangle_count == (1 if kind == ".stl" else 2)
    low, high = scene.bounds()
    turn = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]] if kind in TURNED else np.eye(3))
    corners = np.array(CORNERS) @ turn.T
    np.testing.assert_allclose([low, high], [corners.min(axis=0), corners.max(axis=0)], atol=1e-6)
    instance = scene.instances[0]
    normals = scene.meshes[instance.mesh].normals @ instance.transform[:3, :3].T
    np.testing.assert_allclose(normals, np.broadcast_to(turn @ (0, 0, 1), normals.shape), atol=1e-6)
    assert not scene.warnings


@pytest.mark.parametrize("kind", KINDS)
def test_materials(kind, tmp_path):
    scene = load_assimp(save(tmp_path, "square" + kind, FILES[kind]))
    material = scene.materials[scene.meshes[0].material]
    if kind in WITHOUT_MATERIALS:
        assert (material.base_color, material.specular) == ((0.6, 0.6, 0.6), 0.0)
        return
    assert material.name == ("default" if kind == ".x3d" else "red")  # X3D's have no names
    assert material.base_color == pytest.approx((0.8, 0.1, 0.2), abs=1 / 255)
    assert material.double_sided and material.alpha_mode == "opaque"
    if kind in GLOSSY:
        assert material.specular == pytest.approx(0.5)
        assert material.roughness == pytest.approx(0.5**0.5)


@pytest.mark.covers("model .ply")
def test_vertex_colours_are_srgb_over_white(tmp_path):
    scene = load_assimp(save(tmp_path, "a.ply", ply(colors=True)))
    expected = float(srgb_decode(np.array(188 / 255)))
    np.testing.assert_allclose(scene.meshes[0].colors, [[expected] * 3 + [1.0]] * 4, rtol=1e-6)
    assert scene.materials[0].base_color == (1.0, 1.0, 1.0)


@pytest.mark.covers("model .fbx")
@pytest.mark.parametrize(("up", "far"), [(1, (1, 1, 0)), (2, (1, 0, -1))])
@pytest.mark.parametrize("centimetres", [1.0, 2.54, 100.0])
def test_fbx_in_metres_and_y_up(tmp_path, up, far, centimetres):
    scene = load_assimp(save(tmp_path, "a.fbx", fbx(up, centimetres)))
    mesh, instance = scene.meshes[0], scene.instances[0]
    world = mesh.positions @ instance.transform[:3, :3].T + instance.transform[:3, 3]
    metres = centimetres / 100
    assert np.linalg.norm(world - np.array(far) * metres, axis=1).min() < 1e-6


NODES = ('<node id="a" name="left"><translate>0 0 5</translate>SHOWN'
         '<node id="b" name="child"><translate>2 0 0</translate>SHOWN</node></node>')  # fmt: skip


@pytest.mark.covers("model .dae")
def test_collada_nodes_unit_axis_and_texture(tmp_path, picture):
    picture("Wood.PNG", (9, 8, 7))
    path = save(tmp_path, "a.dae", dae('<texture texture="t" texcoord="UV"/>', "Z_UP", 0.01, NODES))
    scene = load_assimp(path)
    assert scene.triangle_count == 4 and len(scene.instances) == 2
    places = {i.name: i.transform[:3, 3].tolist() for i in scene.instances}
    assert places["a"] == pytest.approx([0, 0.05, 0])
    assert places["b"] == pytest.approx([0.02, 0.05, 0])
    material = scene.materials[0]
    assert material.base_color == (1.0, 1.0, 1.0)
    assert tuple(material.base_color_texture.image.pixels[0, 0]) == (9, 8, 7, 255)
    mesh = scene.meshes[0]
    corner = np.argmin(np.linalg.norm(mesh.positions - (1, 0, 0), axis=1))
    np.testing.assert_allclose(mesh.uvs[corner], (1, 1))  # lower right: v points down


@pytest.mark.covers("model .dae")
def test_textures_named_on_another_computer_are_looked_for_beside_the_model(tmp_path, picture):
    (tmp_path / "textures").mkdir()
    picture("textures/wood.png", (9, 8, 7))
    text = dae('<texture texture="t" texcoord="UV"/>').replace("wood.png", "C:\\maps\\wood.png")
    assert load_assimp(save(tmp_path, "a.dae", text)).warnings == []


@pytest.mark.covers("model .dae")
def test_a_missing_texture_is_a_warning_and_a_checker(tmp_path):
    scene = load_assimp(save(tmp_path, "a.dae", dae('<texture texture="t" texcoord="UV"/>')))
    assert "wood.png" in scene.warnings[0]
    assert scene.materials[0].base_color_texture.image.size == (8, 8)


@pytest.mark.covers("model .ply")
def test_a_cube_keeps_its_edges_and_gentle_bends_are_smooth(tmp_path):
    points = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = "4 0 1 3 2\n4 4 6 7 5\n4 0 4 5 1\n4 2 3 7 6\n4 0 2 6 4\n4 1 5 7 3"
    cube = load_assimp(save(tmp_path, "cube.ply", ply(faces=faces, corners=points))).meshes[0]
    assert {tuple(n) for n in np.abs(cube.normals).round(6).tolist()} == {(1, 0, 0), (0, 1, 0), (0, 0, 1)}
    bend = [(0, 0, 0), (0, 0, 1), (1, 0, 0), (1, 0, 1), (1.8, 0.6, 0), (1.8, 0.6, 1)]  # turns by 36.9 degrees
    mesh = load_assimp(save(tmp_path, "bend.ply", ply(faces="4 0 1 3 2\n4 2 3 5 4", corners=bend))).meshes[0]
    assert len(mesh.positions) == 6
    ridge = mesh.normals[np.abs(mesh.positions[:, 0] - 1) < 1e-6]
    # Two faces of the same area; each gives one triangle or two to a vertex of the ridge, so between 1:2 and 2:1.
    angles = np.degrees(np.arctan2(-ridge[:, 0], ridge[:, 1]))
    assert ((angles > 12) & (angles < 25)).all()


BROKEN = {
    "a.ply": ["", "ply\n", "rubbish", ply(faces="3 0 1 99"), ply()[:-30], ply(faces="3 0 0 0")],
    "a.off": ["", "OFF\n", "OFF\n3 1 0\n0 0 0\n", OFF.replace("4 0 1 2 3", "3 0 1 77"),
              OFF.replace("1 1 0", "nan 1 0")],
    "a.dae": ["", "<COLLADA", dae().replace("1 1 0 0 1 0", "1 1"), dae()[:-400]],
    "a.fbx": ["", "; FBX 7.3.0 project file\n", fbx().replace("0,1,2,-4", "0,1,2,-90"), fbx()[:900]],
    "a.3ds": [b"", b"MM", FILES[".3ds"][:60]],
    "a.3mf": [b"", b"PK\3\4rubbish"],
    "a.stl": ["", "solid x\n", b"\0" * 84 + b"\1", b"\0" * 80 + b"\xff\xff\xff\xff" + b"\0" * 50],
}  # fmt: skip


@pytest.mark.parametrize(("name", "content"), [
    pytest.param(name, content, marks=pytest.mark.covers(f"model {name[1:]}", broken=True))
    for name, all_ in BROKEN.items() for content in all_
])  # fmt: skip
def test_broken_files_are_one_error_or_a_scene(name, content, tmp_path):
    path = save(tmp_path, name, content)
    try:
        scene = load_scene(path)
    except SceneError as error:
        assert error.file == str(path)
        assert error.problem and error.remedy
    else:
        assert all(int(m.indices.max()) < len(m.positions) for m in scene.meshes)


@pytest.mark.covers("model .ply", broken=True)
def test_points_alone_are_refused(tmp_path):
    text = ply().replace("element face 1", "element face 0").replace("4 0 1 2 3\n", "")
    with pytest.raises(SceneError):
        load_assimp(save(tmp_path, "a.ply", text))


CHILDREN = {
    "crashed": "import os; os.abort()",
    "within": "while True: pass",
    "MiB": "bytearray(1 << 62)",
    "exit code 0": "",  # says nothing
}


@pytest.mark.covers("model .ply", broken=True)
@pytest.mark.parametrize("problem", CHILDREN)
def test_crash_hang_and_memory_of_the_importer_are_one_error(problem, tmp_path, monkeypatch):
    monkeypatch.setattr(assimp, "_CHILD", save(tmp_path, "child.py", CHILDREN[problem]))
    monkeypatch.setattr(assimp, "SECONDS", 0.5 if problem == "within" else 20.0)
    path = save(tmp_path, "a.ply", ply())
    with pytest.raises(SceneError, match=problem) as caught:
        load_scene(path)
    assert caught.value.file == str(path)


@pytest.mark.covers("model .ply", broken=True)
def test_the_memory_of_the_importer_is_limited(tmp_path):
    """A header that promises 24 GB of vertices."""
    text = ply().replace("ascii", "binary_little_endian").replace("vertex 4", "vertex 2000000000")
    path = save(tmp_path, "a.ply", text)
    with pytest.raises(SceneError):
        load_scene(path)
