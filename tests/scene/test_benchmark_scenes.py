"""The benchmark scenes say what the ground truth was made from; Crytek Sponza is what its file promises."""

from __future__ import annotations

import json
from math import radians
from pathlib import Path

import numpy as np
import pytest
from mesh_facts import face_normals

from octolux.data import data_folder
from octolux.scene.cameras import look_at
from octolux.scene.lights import AreaLight, DirectionalLight, Light, PointLight
from octolux.scene.load import load_scene

FOLDER = Path(__file__).resolve().parents[2] / "benchmarks" / "scenes"
GROUND_TRUTH = ("cornell_point", "cornell_area", "sponza_sunpoint")

pytestmark = [
    pytest.mark.skipif(not (data_folder() / "scenes").is_dir(), reason="needs OCTOLUX_DATA"),
    pytest.mark.covers("model .toml", files=[f"benchmarks/scenes/{name}.toml" for name in GROUND_TRUTH]),
]


@pytest.fixture(params=GROUND_TRUTH)
def pair(request):
    """A scene and the JSON of its ground truth."""
    path = data_folder() / "ground-truth" / f"{request.param}.json"
    return load_scene(FOLDER / f"{request.param}.toml"), json.loads(path.read_text())


def as_json(light: Light) -> dict:
    """The light in the keys and units of the ground truth."""
    if isinstance(light, PointLight):
        return {"type": "point", "position": list(light.position), "intensity_W_per_sr": list(light.intensity)}
    if isinstance(light, DirectionalLight):
        return {"type": "directional", "direction_of_travel": list(light.direction),
                "irradiance_W_per_m2": list(light.illuminance)}
    assert isinstance(light, AreaLight)
    return {"type": "area", "quad": [list(c) for c in light.corners], "radiance_W_per_m2_sr": list(light.radiance)}


def test_camera_is_that_of_the_ground_truth(pair):
    scene, truth = pair
    camera, expected = scene.cameras[0], truth["camera"]
    np.testing.assert_array_equal(
        camera.transform, look_at(expected["look_from"], expected["look_at"], expected["up"])
    )
    assert camera.vertical_fov == radians(expected["vfov_deg"])


def test_lights_are_those_of_the_ground_truth(pair):
    scene, truth = pair
    expected = [{k: v for k, v in light.items() if k not in ("material", "note")} for light in truth["lights"]]
    assert [as_json(light) for light in scene.lights] == expected
    assert scene.environment.is_black


def test_materials_are_those_of_the_ground_truth(pair):
    scene, truth = pair
    used = {scene.materials[scene.meshes[i.mesh].material].name for i in scene.instances}
    assert {m.name: list(m.base_color) for m in scene.materials if m.name in used} == truth["materials"]
    for m in scene.materials:
        assert (m.specular, m.metallic, m.emissive, m.alpha_mode) == (0.0, 0.0, (0.0, 0.0, 0.0), "opaque")
        assert m.double_sided
        assert m.base_color_texture is m.normal_texture is m.metallic_roughness_texture is m.emissive_texture is None


def test_normals_are_those_of_the_faces(pair):
    scene, _ = pair
    for mesh in scene.meshes:
        a, b, c = np.moveaxis(mesh.positions[mesh.indices].astype(np.float64), 1, 0)
        sound = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-9  # the file has triangles without area
        with np.errstate(invalid="ignore"):
            expected = face_normals(mesh)[sound]
        for corner in range(3):
            np.testing.assert_allclose(mesh.normals[mesh.indices[sound, corner]], expected, atol=1e-5)


@pytest.mark.covers("model .toml", files=["benchmarks/scenes/crytek_sponza.toml"])
def test_crytek_sponza_is_in_metres_with_textures_and_normal_maps():
    scene = load_scene(FOLDER / "crytek_sponza.toml")
    low, high = scene.bounds()
    assert scene.triangle_count == 262_267
    np.testing.assert_allclose(high - low, [37.2, 15.6, 22.9], atol=0.1)
    assert sum(m.base_color_texture is not None for m in scene.materials) > 20
    assert sum(m.normal_texture is not None for m in scene.materials) > 5
    assert scene.at(0.0).lights == scene.lights  # the first frame is the still picture
