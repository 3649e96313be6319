"""`octolux export`: Mitsuba loads the file, it shows what the description shows, and bad targets give one error."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from gpu_tools import scene_of
from mitsuba_tools import as_dict, mi, needs_llvm

from octolux.export.command import export_scene
from octolux.export.files import FileFolder
from octolux.export.mitsuba import mitsuba_description, write_mitsuba
from octolux.export.ply import world_arrays
from octolux.scene.builtin.shapes import box, quad
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.errors import OctoluxError
from octolux.scene.lights import AreaLight, DirectionalLight, PointLight, SpotLight
from octolux.scene.materials import Image, Material, Texture
from octolux.scene.meshes import Instance

SIZE = (32, 24)
VIEW = Camera.look_at((0.5, 1.0, 3.0), (0.0, 0.3, 0.0), vertical_fov=0.9)


def everything():
    """One of each: lights, surroundings, kinds of material and textures, a mirrored instance, a name to be cleaned."""
    rng = np.random.default_rng(2)
    picture = Texture(Image(rng.integers(100, 256, (8, 8, 4), dtype=np.uint8), "a picture"))
    materials = [
        Material(name="floor.", specular=0.0, base_color_texture=picture),
        Material(name="metal", metallic=1.0, roughness=0.4, metallic_roughness_texture=picture, normal_texture=picture),
        Material(name="glow", emissive=(2.0, 1.0, 0.5), emissive_texture=picture, double_sided=True),
        Material(name="net", base_color_texture=picture, alpha_mode="mask", alpha_cutoff=0.6),
        Material(name="veil", base_color=(1.0, 0.5, 0.5), alpha=0.5, alpha_mode="blend", roughness=0.5),
        Material(name="label", unlit=True),
    ]
    floor = quad([(-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)])
    shapes = [box((0, 0, 0), (0.5, 0.5, 0.5), material=n) for n in range(1, 6)]
    colors = np.full((len(shapes[3].positions), 4), 0.5, np.float32)
    shapes[3] = replace(shapes[3], colors=colors)
    instances = [Instance(0)]
    for n in range(5):
        transform = np.diag([-1.0 if n == 0 else 1.0, 1.0, 1.0, 1.0])
        transform[0, 3] = -1.5 + 0.6 * n
        instances.append(Instance(n + 1, transform, name=f"cube/{n}"))
    panel = ((0.0, 1.5, 0.0), (0.4, 1.5, 0.0), (0.4, 1.5, -0.4), (0.0, 1.5, -0.4))
    lights = [
        DirectionalLight(direction=(0.3, -1.0, -0.4), illuminance=(1.0, 1.0, 1.0)),
        PointLight(position=(-1.0, 1.0, 1.0), intensity=(1.0, 0.5, 0.5)),
        SpotLight(position=(1.0, 1.5, 1.0), direction=(-1.0, -1.0, -1.0), intensity=(2.0, 2.0, 3.0)),
        AreaLight(corners=panel, radiance=(5.0, 5.0, 5.0)),
    ]
    environment = Environment((0.1, 0.1, 0.1), rng.uniform(0, 1, (4, 8, 3)).astype(np.float32), 0.3)
    return scene_of([floor, *shapes], materials, instances=instances, lights=lights, environment=environment)


def test_the_file_shows_what_the_description_shows(tmp_path):
    """With one seed the same picture; reading numbers back from text changes none of them by more than a rounding."""
    warnings = write_mitsuba(everything(), tmp_path / "scene.xml", VIEW, SIZE, samples=8)
    described = mitsuba_description(everything(), VIEW, SIZE, FileFolder(tmp_path / "scene_files"), samples=8)
    pictures = [np.array(mi.render(mi.load_file(str(tmp_path / "scene.xml")), seed=3)),
                np.array(mi.render(mi.load_dict(as_dict(described, tmp_path)), seed=3))]  # fmt: skip
    assert pictures[0].shape == (SIZE[1], SIZE[0], 3)
    assert pictures[0].mean() > 0.1
    assert np.isfinite(pictures[0]).all()
    assert np.allclose(*pictures, rtol=1e-5, atol=1e-5)
    assert warnings == ["material 'label': unlit: Mitsuba has no such thing, it is left black"]


def test_what_is_written(tmp_path):
    write_mitsuba(everything(), tmp_path / "scene.xml", VIEW, SIZE)
    root = ElementTree.parse(tmp_path / "scene.xml").getroot()
    integrator = root.find("integrator")
    assert integrator is not None and integrator.get("type") == "volpath"  # light passes what is cut out
    named = {e.get("value") for e in root.iter("string") if e.get("name") == "filename"}
    assert named == {f"scene_files/{file.name}" for file in (tmp_path / "scene_files").iterdir()}
    raw = {e.find("string").get("value"): e.find("boolean").get("value") for e in root.iter("texture")
           if e.get("type") == "bitmap"}  # fmt: skip
    assert {name for name, value in raw.items() if value == "false"} == {"scene_files/image-0.png"}
    # A surface that glows on both sides is two.
    assert sum(e.find("emitter") is not None for e in root.iter("shape")) == 3
    # Without transparency and area lights the simpler integrator will do.
    simple = replace(everything(), instances=[Instance(0)], lights=everything().lights[:3])
    write_mitsuba(simple, tmp_path / "simple.xml", VIEW, SIZE)
    assert 'integrator type="path"' in (tmp_path / "simple.xml").read_text()


def test_what_cannot_be_said_is_told(tmp_path):
    texture = Texture(Image(np.full((2, 2, 4), 128, np.uint8), "tile"), ("repeat", "clamp_to_edge"))
    mesh = quad([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    scene = scene_of([replace(mesh, colors=np.ones((4, 4), np.float32))], [Material(base_color_texture=texture)])
    assert write_mitsuba(scene, tmp_path / "scene.xml", VIEW, SIZE) == [
        "material '': vertex colours of a textured material are left out",
        "image 'tile': it wraps as repeat in both directions",
    ]


def test_a_mirrored_mesh_keeps_its_front():
    mesh = box((0, 0, 0), (1, 1, 1))
    positions, normals, indices = world_arrays(mesh, np.diag([-2.0, 1.0, 3.0, 1.0]))
    corners = positions[indices]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.all((faces * normals[indices[:, 0]]).sum(axis=1) > 0)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert np.all(((positions - positions.mean(axis=0)) * normals).sum(axis=1) > 0)


def test_command(tmp_path):
    """The camera by name, the time, and the sun and sky of scenes in which nothing shines."""
    out = tmp_path / "scene.xml"
    assert export_scene("cornell-box", out, "front", (40, 30), time=1.0) == []
    text = out.read_text()
    assert 'name="width" value="40"' in text
    assert '<point name="position" x="0.6" y="1.75" z="0.5" />' in text  # where the lamp is after a second
    mesh = tmp_path / "triangle.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert any("nothing in the scene shines" in note for note in export_scene(str(mesh), out))
    assert 'emitter type="directional"' in out.read_text()
    assert not any("nothing in the scene shines" in note for note in export_scene(str(mesh), out, default_light=False))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"out": "scene.obj"}, "'.obj' are not written. Use .xml"),
        ({"out": "nowhere/scene.xml"}, "there is no folder"),
        ({"out": "taken.xml"}, "no folder can be made there"),
        ({"camera": "back"}, "The scene has no camera 'back'. There are: 0 'front'."),
        ({"clip": "walk"}, "has no animation 'walk'"),
        ({"size": (0, 9)}, "must be 1 to 8192 pixels, not 0x9"),
        ({"time": float("nan")}, "--time is a number of seconds"),
        ({"source": "no-such-scene"}, "there is no such file or built-in scene"),
    ],
)
def test_one_error(tmp_path, arguments, message):
    (tmp_path / "taken_files").write_text("a file where the folder has to be")
    before = sorted(tmp_path.iterdir())
    chosen = {"source": "cornell-box", **arguments, "out": tmp_path / arguments.get("out", "scene.xml")}
    with pytest.raises(OctoluxError) as caught:
        export_scene(**chosen)
    assert message in str(caught.value)
    assert sorted(tmp_path.iterdir()) == before


def test_a_full_disk_leaves_no_scene(tmp_path, monkeypatch):
    def full(path: Path, *_):
        path.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("octolux.export.mitsuba.write_ply", full)
    with pytest.raises(OctoluxError, match="No space left"):
        write_mitsuba(everything(), tmp_path / "scene.xml", VIEW, SIZE)
    assert not (tmp_path / "scene.xml").exists()
    assert not list((tmp_path / "scene_files").glob("*.ply"))


@needs_llvm
@pytest.mark.parametrize(("metallic", "roughness", "most"), [(0.0, 0.3, 0.07), (0.0, 1.0, 0.11), (1.0, 0.3, 0.005)])
def test_how_near_principled_is(metallic, roughness, most):
    """A plane in even light, seen at 30 and 60 degrees: what docs/export.md says of `principled`."""
    for degrees in (30, 60):
        found = [plane_albedo(kind, metallic, roughness, degrees) for kind in ("principled", "octolux_gltf")]
        assert abs(found[0] / found[1] - 1.0) < most


def plane_albedo(kind: str, metallic: float, roughness: float, degrees: float) -> float:
    """Share of even light that a surface of base colour 0.5 reflects, by sampling its BSDF: good to 2e-3."""
    bsdf = mi.load_dict({"type": kind, "base_color": {"type": "rgb", "value": 0.5}, "metallic": metallic,
                         "roughness": roughness, "specular": 0.5})  # fmt: skip
    count = 1 << 18
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(1, count)
    si = mi.SurfaceInteraction3f()
    si.n = mi.Normal3f(0, 0, 1)
    si.sh_frame = mi.Frame3f(si.n)
    angle = np.radians(degrees)
    si.wi = mi.Vector3f(float(np.sin(angle)), 0.0, float(np.cos(angle)))
    _, weight = bsdf.sample(mi.BSDFContext(), si, sampler.next_1d(), sampler.next_2d())
    return float(np.mean(np.array(weight)))
