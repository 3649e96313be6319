"""Scenes for Mitsuba 3: an XML file and a folder of meshes and pictures beside it. Mitsuba itself is not needed."""

from __future__ import annotations

import re
from math import degrees
from pathlib import Path
from typing import Any

import numpy as np

from ..output import check_writable
from ..output.atomic import replacing
from ..scene.cameras import Camera
from ..scene.lights import AreaLight, Light, ParticleLights, PointLight, SingleLight
from ..scene.meshes import Instance, Mesh
from ..scene.scene import Scene
from .files import FileFolder
from .mitsuba_lights import environment, light
from .mitsuba_materials import Description, MaterialWriter
from .mitsuba_xml import scene_xml
from .ply import world_arrays, write_ply

SHEET = 1e-5
"""A surface that glows on both sides is two sheets, since Mitsuba's emitters are one-sided; each is so far, in
diameters of the scene, from where it was. It is about 100 roundings of a float32 coordinate."""


def write_mitsuba(
    scene: Scene, path: str | Path, camera: Camera, size: tuple[int, int], samples: int = 64
) -> list[str]:  # fmt: skip
    """Write `path` (.xml), and what it names into the folder `STEM_files` beside it.

    size: (width, height), pixels.  samples: a pixel. Returns what could not be said in Mitsuba's terms. The scene is
    taken as it is, without keyframes (`Scene.at`). Files of a former export are replaced, each at once; the XML file
    comes last. Raises OctoluxError.
    """
    path = Path(path)
    check_writable(path, [".xml"])
    warnings: list[str] = []
    files = FileFolder(path.with_name(f"{path.stem}_files"))
    description = mitsuba_description(scene, camera, size, files, samples=samples, warnings=warnings)
    with replacing(path) as temporary:
        temporary.write_text(scene_xml(description), encoding="utf-8")
    return warnings


def mitsuba_description(
    scene: Scene, camera: Camera, size: tuple[int, int], files: FileFolder, *, samples: int = 64,
    warnings: list[str] | None = None, exact: bool = False,
) -> Description:  # fmt: skip
    """The scene as nested dictionaries in the form of `mitsuba.load_dict`, but with NumPy matrices for transforms and
    file names relative to the parent of `files`; `mitsuba_xml.scene_xml` writes it down.

    exact: materials that are not Lambertian are `octolux_gltf`, which has to be registered with Mitsuba.
    """
    warnings = [] if warnings is None else warnings
    writer = MaterialWriter(files, warnings, exact)
    used = {scene.meshes[i.mesh].material for i in scene.instances}
    clear = any(writer.is_transparent(scene.materials[n]) for n in used)
    clear |= any(isinstance(source, AreaLight) for source in scene.lights)
    description: Description = {
        "type": "scene",
        # Only the volumetric integrator lets light through what is cut out, and through area lights.
        "integrator": {"type": "volpath" if clear else "path", "max_depth": -1},
        "sensor": _sensor(camera, size, samples, _reach(scene, camera)),
    }
    description |= _shapes(scene, writer, files)
    lights = [each for source in scene.lights for each in _single(source)]
    description |= {f"light-{n}": light(source, n, files) for n, source in enumerate(lights)}
    surroundings = environment(scene.environment, files)
    return description if surroundings is None else {**description, "surroundings": surroundings}


def _single(source: Light) -> list[SingleLight]:
    """A light as it is, and particles as the point lights that they are."""
    if not isinstance(source, ParticleLights):
        return [source]
    pairs = zip(source.positions.tolist(), source.intensities.tolist(), strict=True)
    return [PointLight(position=(x, y, z), intensity=(r, g, b)) for (x, y, z), (r, g, b) in pairs]


def _reach(scene: Scene, camera: Camera) -> float:
    """Metres from the camera to beyond all that it may see."""
    corners = np.stack(scene.bounds())
    return 2.0 * float(np.linalg.norm(np.abs(corners - camera.position).max(axis=0))) + 1.0


def _sensor(camera: Camera, size: tuple[int, int], samples: int, reach: float) -> Description:
    """Mitsuba's cameras look along +z with +x to the left: ours, turned half around +y."""
    to_world = camera.transform @ np.diag([-1.0, 1.0, -1.0, 1.0])
    near = float(camera.near)
    sensor: Description = {"near_clip": near, "far_clip": near + reach}
    width, height = size
    if camera.orthographic_height is None:
        sensor |= {"type": "perspective", "fov": degrees(camera.vertical_fov), "fov_axis": "y"}
    else:
        half = 0.5 * camera.orthographic_height * width / height  # the picture's width is 2, before scaling
        to_world = to_world @ np.diag([half, half, 1.0, 1.0])
        sensor["type"] = "orthographic"
    film = {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb", "component_format": "float32",
            "rfilter": {"type": "box"}}  # fmt: skip
    return {**sensor, "to_world": to_world, "film": film, "sampler": {"type": "independent", "sample_count": samples}}


def _shapes(scene: Scene, writer: MaterialWriter, files: FileFolder) -> Description:
    """BSDFs that are used, and a shape for each instance, in world space."""
    bsdfs: Description = {}
    shapes: Description = {}
    for number, instance in enumerate(scene.instances):
        mesh = scene.meshes[instance.mesh]
        if not len(mesh.indices):
            continue
        material = scene.materials[mesh.material]
        colored = mesh.colors is not None
        name = _identifier("material", mesh.material, material.name) + ("-colored" if colored else "")
        bsdfs.setdefault(name, writer.bsdf(material, colored))
        emitter = writer.emitter(material)
        both = emitter is not None and material.double_sided
        gap = SHEET * float(np.linalg.norm(np.subtract(*scene.bounds()))) if both else 0.0
        for side in (1, -1) if both else (1,):
            key = _identifier("shape", number, instance.name) + ("" if side > 0 else "-back")
            shapes[key] = {"type": "ply", "filename": _mesh_file(files, key, mesh, instance, material, side, gap),
                           "bsdf": {"type": "ref", "id": name}}  # fmt: skip
            if emitter is not None:
                shapes[key]["emitter"] = emitter
    return bsdfs | shapes


def _mesh_file(
    files: FileFolder, key: str, mesh: Mesh, instance: Instance, material: Any, side: int, gap: float
) -> str:  # fmt: skip
    """The PLY file of an instance; side -1 is turned inside out; both are moved apart by `gap`."""
    positions, normals, indices = world_arrays(mesh, instance.transform)
    if side < 0:
        normals, indices = -normals, indices[:, ::-1]
    colors = None if mesh.colors is None else mesh.colors[:, :3] * np.asarray(material.base_color)
    return files.once(
        key, f"{key}.ply", lambda path: write_ply(path, positions + gap * normals, normals, indices, mesh.uvs, colors)
    )


def _identifier(kind: str, number: int, name: str) -> str:
    """Mitsuba allows no dots in names, and not all systems all letters in those of files."""
    return f"{kind}-{number}" + (f"-{re.sub(r'[^A-Za-z0-9_-]+', '_', name)[:40]}" if name else "")
