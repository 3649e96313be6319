"""OBJ and MTL."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from octolux.scene.errors import SceneError
from octolux.scene.materials import Image
from octolux.scene.obj.image_maps import is_normal_map, normals_from_height, with_green_up
from octolux.scene.obj.loader import load_obj
from octolux.scene.obj.materials import roughness

pytestmark = pytest.mark.covers("model .obj")

QUAD = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
FACE = "f 1/1 2/2 3/3 4/4\n"


def write(folder: Path, obj: str, mtl: str = "") -> Path:
    (folder / "model.mtl").write_text(mtl)
    (folder / "model.obj").write_text(("mtllib model.mtl\n" if mtl else "") + obj)
    return folder / "model.obj"


def material(folder: Path, lines: str):
    return load_obj(write(folder, QUAD + "usemtl m\n" + FACE, "newmtl m\n" + lines)).materials[0]


def test_groups_become_instances_and_v_is_flipped(tmp_path):
    scene = load_obj(write(tmp_path, QUAD + "g left\nf 1/1 2/2 3/3\ng right\nf 1/1 3/3 4/4\n"))
    assert [instance.name for instance in scene.instances] == ["left", "right"]
    assert scene.triangle_count == 2
    mesh = scene.meshes[0]
    corner = mesh.uvs[np.argmin(np.linalg.norm(mesh.positions - (1, 0, 0), axis=1))]
    np.testing.assert_allclose(corner, (1, 1))
    assert scene.materials[0].base_color == (0.6, 0.6, 0.6)


def test_negative_indices_count_back_from_the_face(tmp_path):
    later = "v 0 0 5\nv 1 0 5\nv 1 1 5\n"
    scene = load_obj(write(tmp_path, QUAD + "f -4 -3 -2\n" + later + "f -3 -2 -1\n"))
    assert scene.bounds()[1][2] == 5
    assert scene.triangle_count == 2


def test_faces_without_normals_are_flat_and_given_ones_are_kept(tmp_path):
    corner = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    flat = load_obj(write(tmp_path, corner + "f 1 2 3\nf 1 3 4\n")).meshes[0]
    np.testing.assert_allclose(flat.normals, np.repeat([[0, 0, 1], [1, 0, 0]], 3, axis=0), atol=1e-6)
    smooth = load_obj(write(tmp_path, corner + "vn 0 3 4\nf 1//1 2//1 3//1\n")).meshes[0]
    np.testing.assert_allclose(smooth.normals, [[0, 0.6, 0.8]] * 3, atol=1e-6)


def test_lines_beside_faces_are_left_out_with_a_warning(tmp_path):
    scene = load_obj(write(tmp_path, QUAD + FACE + "l 1 2 3\np 1\n"))
    assert scene.triangle_count == 2
    assert "lines and points" in scene.warnings[0]


def test_texture_is_found_by_backslash_and_case_and_replaces_kd(tmp_path, picture):
    (tmp_path / "Textures").mkdir()
    picture("Textures/Wood.PNG", (10, 20, 30))
    found = material(tmp_path, "Kd 0.588 0.588 0.588\nmap_Kd textures\\wood.png\n")
    assert found.base_color == (1.0, 1.0, 1.0)
    assert tuple(found.base_color_texture.image.pixels[0, 0]) == (10, 20, 30, 255)


def test_mask_goes_into_the_alpha_of_the_base_color(tmp_path, picture):
    picture("color.png", (10, 20, 30), size=(8, 8))
    picture("mask.png", np.repeat([[[255], [0]]], 3, axis=2))
    found = material(tmp_path, "map_Kd color.png\nmap_d mask.png\n")
    assert found.alpha_mode == "mask"
    pixels = found.base_color_texture.image.pixels
    assert pixels.shape == (8, 8, 4)
    assert (pixels[:, 0, 3] == 255).all()
    assert (pixels[:, -1, 3] == 0).all()
    assert (pixels[..., :3] == (10, 20, 30)).all()


def test_the_same_texture_is_one_image(tmp_path, picture):
    picture("t.png", (1, 2, 3))
    mtl = "newmtl a\nmap_Kd t.png\nnewmtl b\nmap_Kd t.png\n"
    scene = load_obj(write(tmp_path, QUAD + "usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n", mtl))
    a, b = (m.base_color_texture.image for m in scene.materials)
    assert a is b


@pytest.mark.parametrize(
    ("lines", "alpha"),
    [("d 1\nTr 0\n", 1.0), ("d 0.25\n", 0.25), ("Tr 0.25\n", 0.75), ("Tr 1\n", 1.0), ("d 1\nTr 1\n", 1.0)],
)
def test_opacity(tmp_path, lines, alpha):
    found = material(tmp_path, lines)
    assert found.alpha == alpha
    assert found.alpha_mode == ("blend" if alpha < 1 else "opaque")


def test_specular_roughness_and_emission(tmp_path):
    matt = material(tmp_path, "Kd 0.2 0.3 0.4\nKs 0 0 0\nKe 17 12 4\n")
    assert (matt.base_color, matt.specular, matt.metallic) == ((0.2, 0.3, 0.4), 0.0, 0.0)
    assert matt.emissive == (17.0, 12.0, 4.0)
    assert matt.double_sided
    half = material(tmp_path, "Kd 0.5 0.5 0.5\nKs 0.02 0.02 0.02\nNs 6\n")
    assert half.specular == pytest.approx(0.5)
    assert half.roughness == pytest.approx(0.5**0.5)  # alpha = sqrt(2 / 8) = 0.5
    mirror = material(tmp_path, "Kd 0.01 0.01 0.01\nKs 0.95 0.9 0.85\nillum 5\n")
    assert (mirror.base_color, mirror.metallic) == ((0.95, 0.9, 0.85), 1.0)
    assert roughness(0.0) == 1.0


@pytest.mark.covers("model .obj", broken=True)
def test_missing_files_are_noted_and_stand_ins_are_used(tmp_path):
    scene = load_obj(write(tmp_path, QUAD + "usemtl m\n" + FACE, "newmtl m\nmap_Kd nowhere.png\n"))
    assert "nowhere.png" in scene.warnings[0]
    assert {tuple(p) for p in scene.materials[0].base_color_texture.image.pixels.reshape(-1, 4)} == {
        (255, 0, 255, 255),
        (0, 0, 0, 255),
    }
    (tmp_path / "model.mtl").unlink()
    scene = load_obj(tmp_path / "model.obj")
    assert "model.mtl" in scene.warnings[0]
    assert "material 'm'" in scene.warnings[1]


@pytest.mark.covers("model .obj", broken=True)
def test_a_library_with_an_impossible_name_is_noted(tmp_path):
    scene = load_obj(write(tmp_path, "mtllib a\0b.mtl\n" + QUAD + FACE))
    assert "a\0b.mtl" in scene.warnings[0]


def bumps(height: int = 32, width: int = 48) -> Image:
    y, x = np.indices((height, width))
    grey = 127 + 100 * np.sin(x * 2 * np.pi / width * 3) * np.cos(y * 2 * np.pi / height * 2)
    return Image(np.dstack([grey, grey, grey, np.full_like(grey, 255)]).astype(np.uint8), "bumps")


def test_heights_become_normals_with_green_up():
    height = bumps()
    normals = normals_from_height(height, 4.0)
    assert not is_normal_map(height)
    assert is_normal_map(normals)
    # Where the height falls to the right the normal leans right; where it falls upwards the normal leans up.
    grey = height.pixels[..., 0].astype(int)
    falls_right = np.roll(grey, 1, axis=1) - np.roll(grey, -1, axis=1)
    falls_up = np.roll(grey, -1, axis=0) - np.roll(grey, 1, axis=0)
    assert (normals.pixels[falls_right > 10, 0] > 127).all()
    assert (normals.pixels[falls_up > 10, 1] > 127).all()


def test_green_that_points_down_is_turned_up():
    up = normals_from_height(bumps(), 4.0)
    down = Image(np.dstack([up.pixels[..., 0], 255 - up.pixels[..., 1], up.pixels[..., 2:]]), "down")
    assert with_green_up(up, otherwise=False) is up
    np.testing.assert_array_equal(with_green_up(down, otherwise=True).pixels, up.pixels)


@pytest.mark.covers("model .obj", broken=True)
@pytest.mark.parametrize(
    ("text", "place", "problem"),
    [
        ("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n", "line 4", "asks for number 9 of 3"),
        ("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 0\n", "line 4", "number 0"),
        ("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 x\n", "line 4", "whole numbers"),
        ("v 0 0 0\nv 1 0 0\nv 1 inf 0\nf 1 2 3\n", "line 3", "not finite"),
        ("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "", "no triangle with an area"),
        ("", "", "no vertices"),
    ],
)
def test_broken_text_names_the_line(tmp_path, text, place, problem):
    with pytest.raises(SceneError) as caught:
        load_obj(write(tmp_path, text))
    assert caught.value.place == place
    assert problem in caught.value.problem
    assert caught.value.remedy


@pytest.mark.covers("model .obj", broken=True)
@pytest.mark.parametrize("line", ["Kd 1 x 1", "Kd 1 nan 1", "Kd 1 1", "Ns 1e999", "Ke -1 0 0"])
def test_broken_material_names_the_line(tmp_path, line):
    with pytest.raises(SceneError) as caught:
        material(tmp_path, line + "\n")
    assert caught.value.file.endswith("model.mtl")
    assert caught.value.place == "line 2"


@pytest.mark.covers("model .obj", broken=True)
def test_broken_image_names_the_image(tmp_path):
    (tmp_path / "t.png").write_bytes(b"\x89PNG\r\n\x1a\nrubbish")
    with pytest.raises(SceneError) as caught:
        material(tmp_path, "map_Kd t.png\n")
    assert caught.value.file.endswith("t.png")
