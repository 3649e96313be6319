"""What a scene holds, as facts for programs (JSON) and lines for people: the command `octolux info`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields
from math import degrees
from pathlib import Path
from typing import Any

from .gpu.memory import readable
from .gpu_scene.mipmaps import size_class
from .scene.gltf.container import read_container
from .scene.lights import AreaLight, DirectionalLight, Light, ParticleLights
from .scene.load import load_scene
from .scene.materials import Image, Material, Texture
from .scene.medium import Medium
from .scene.scene import Scene

# A hall is some 40 m long and a town block 200; a model longer than a kilometre is more often a small one in a smaller
# unit, and one below 2 mm a larger one in a larger unit. (limit, metres in that unit, its name, its name in TOML)
_LARGE = ((50_000.0, 0.001, "millimetres", '"mm"'), (1_000.0, 0.01, "centimetres", '"cm"'))
_SMALL = 0.002


def scene_facts(source: str) -> dict[str, Any]:
    """Everything that `octolux info` tells about a file or built-in scene, ready for JSON; docs/scenes.md lists it.

    Lengths in metres, light in its unit, memory in bytes. Raises SceneError as `load_scene` does.
    """
    scene = load_scene(source)
    path = Path(source)
    is_file = path.is_file()
    low, high = scene.bounds()
    size = (high - low).tolist()
    return {
        "source": source,
        "format": path.suffix.lower().removeprefix(".") if is_file else "built-in",
        "file_bytes": path.stat().st_size if is_file else None,
        "triangles": scene.triangle_count,
        "vertices": sum(len(mesh.positions) for mesh in scene.meshes),
        "meshes": len(scene.meshes),
        "instances": len(scene.instances),
        "nodes": len(scene.nodes),
        "skins": len(scene.skins),
        "morph_targets": sum(len(m.deformable.targets) for m in scene.meshes if m.deformable),
        "low": low.tolist(), "high": high.tolist(), "size": size, "size_hint": size_hint(max(size)),
        "materials": [_material(m) for m in scene.materials],
        "textures": _textures(scene),
        "lights": [_light(light) for light in scene.lights],
        "cameras": [_camera(camera) for camera in scene.cameras],
        "clips": _clips(scene),
        "environment": _environment(scene),
        "medium": _medium(scene.medium),
        "exposure": scene.exposure,
        "extensions": _extensions(path) if is_file else [],
        "warnings": scene.warnings,
    }  # fmt: skip


def size_hint(longest: float) -> str:
    """What to try when a model of this longest side, metres, is probably in another unit; else ""."""
    for limit, metres, name, written in _LARGE:
        if longest > limit:
            return f"perhaps it is in {name}: unit = {written} in a TOML scene makes it {longest * metres:.3g} m"
    return "perhaps its unit is larger than a metre; see 'unit' and 'scale' of TOML scenes" if longest < _SMALL else ""


def _slots(material: Material) -> Iterator[tuple[str, Texture]]:
    for field in fields(material):
        value = getattr(material, field.name)
        if isinstance(value, Texture):
            yield field.name.removesuffix("_texture"), value


def _material(material: Material) -> dict[str, Any]:
    return {
        "name": material.name, "alpha_mode": material.alpha_mode, "double_sided": material.double_sided,
        "unlit": material.unlit, "emissive": max(material.emissive) > 0, "textures": [s for s, _ in _slots(material)],
    }  # fmt: skip


def _textures(scene: Scene) -> list[dict[str, Any]]:
    """Each image once, with the slots that use it and what its mip maps take on the device, a third more than its
    largest level, for each colour space that it is used in."""
    images: dict[int, tuple[Image, set[str]]] = {}
    for material in scene.materials:
        for slot, texture in _slots(material):
            images.setdefault(id(texture.image), (texture.image, set()))[1].add(slot)
    result = []
    for image, slots in images.values():
        spaces = len({slot in ("base_color", "emissive") for slot in slots})
        memory = spaces * sum(4 * 4**level for level in range(size_class(image).bit_length()))
        width, height = image.size
        result.append({"name": image.name, "width": width, "height": height, "used_as": sorted(slots), "bytes": memory})
    return result


def _light(light: Light) -> dict[str, Any]:
    if isinstance(light, DirectionalLight):
        kind, value, unit = "directional", light.illuminance, "lux"
    elif isinstance(light, AreaLight):
        kind, value, unit = "area", light.radiance, "nits"
    elif isinstance(light, ParticleLights):
        kind, value = "particles", light.intensities.sum(axis=0).tolist()
        unit = f"candela, {len(light.positions):,} together"
    else:
        kind, value, unit = type(light).__name__.removesuffix("Light").lower(), light.intensity, "candela"
    return {"name": light.name, "type": kind, "value": list(value), "unit": unit}


def _camera(camera: Any) -> dict[str, Any]:
    fov = None if camera.orthographic_height else degrees(camera.vertical_fov)
    return {"name": camera.name, "position": camera.position.tolist(), "vertical_fov": fov,
            "orthographic_height": camera.orthographic_height}  # fmt: skip


def _clips(scene: Scene) -> list[dict[str, Any]]:
    names = dict.fromkeys(track.clip for track in scene.tracks)
    clips = {name: [track for track in scene.tracks if track.clip == name] for name in names}
    return [{"name": name, "seconds": max(float(t.times[-1]) for t in tracks), "tracks": len(tracks)}
            for name, tracks in clips.items()]  # fmt: skip


def _environment(scene: Scene) -> dict[str, Any]:
    image = scene.environment.image
    size = None if image is None else [image.shape[1], image.shape[0]]
    return {"radiance": list(scene.environment.radiance), "image_size": size}


def _medium(medium: Medium | None) -> dict[str, Any] | None:
    if medium is None:
        return None
    cells = None if medium.density is None else list(medium.density.shape[::-1])
    return {"scattering": list(medium.scattering), "absorption": list(medium.absorption), "cells": cells,
            "low": medium.low and list(medium.low), "high": medium.high and list(medium.high)}  # fmt: skip


def _extensions(path: Path) -> list[str]:
    """The glTF extensions that a file says it uses; it has been loaded and is well formed."""
    is_gltf = path.suffix.lower() in (".gltf", ".glb")
    return read_container(path)[0].strings("extensionsUsed") if is_gltf else []


def info_lines(facts: dict[str, Any]) -> Iterator[str]:
    """The facts as lines of text."""
    size = f", {readable(facts['file_bytes'])}" if facts["file_bytes"] is not None else ""
    yield f"{facts['source']}: {facts['format']}{size}"
    yield "  " + ", ".join(f"{facts[key]:,} {key.replace('_', ' ')}" for key in (
        "triangles", "vertices", "meshes", "instances", "nodes", "skins", "morph_targets") if facts[key])  # fmt: skip
    sides = " x ".join(f"{side:.4g}" for side in facts["size"])
    yield f"  size {sides} m, from {_point(facts['low'])} to {_point(facts['high'])}"
    if facts["size_hint"]:
        yield f"  hint: {facts['size_hint']}"
    for title, line in _SECTIONS:
        entries = facts[title]
        if entries:
            total = f", {readable(sum(t['bytes'] for t in entries))} on the device" if title == "textures" else ""
            yield f"{title}: {len(entries)}{total}"
            yield from (f"  {line(entry)}" for entry in entries)
    yield from _surroundings(facts)
    if facts["extensions"]:
        yield f"extensions: {', '.join(facts['extensions'])}"
    yield from (f"warning: {warning}" for warning in facts["warnings"])


def _surroundings(facts: dict[str, Any]) -> Iterator[str]:
    sky = facts["environment"]
    image = f", image {sky['image_size'][0]} x {sky['image_size'][1]}" if sky["image_size"] else ""
    if image or max(sky["radiance"]) > 0:
        yield f"environment: {_point(sky['radiance'])} nits{image}"
    if medium := facts["medium"]:
        cells = ", density of {} x {} x {} cells".format(*medium["cells"]) if medium["cells"] else ""
        yield f"medium: scatters {_point(medium['scattering'])}, absorbs {_point(medium['absorption'])} 1/m{cells}"
    yield "exposure: metered" if facts["exposure"] is None else f"exposure: EV100 {facts['exposure']:g}"


def _point(values: list[float]) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in values) + ")"


def _material_line(m: dict[str, Any]) -> str:
    marks = [m["alpha_mode"], *(mark for mark in ("double_sided", "unlit", "emissive") if m[mark])]
    textures = f"; textures: {', '.join(m['textures'])}" if m["textures"] else ""
    return f"{m['name'] or '(no name)'}: {', '.join(marks)}{textures}".replace("double_sided", "double sided")


def _texture_line(t: dict[str, Any]) -> str:
    uses = ", ".join(t["used_as"]).replace("_", " ")
    return f"{t['name'] or '(no name)'}: {t['width']} x {t['height']}, {uses}, {readable(t['bytes'])}"


def _camera_line(c: dict[str, Any]) -> str:
    view = f"{c['orthographic_height']:g} m high" if c["vertical_fov"] is None else f"{c['vertical_fov']:.3g} degrees"
    return f"{c['name'] or '(no name)'}: at {_point(c['position'])}, {view}"


_SECTIONS: tuple[tuple[str, Callable[[dict[str, Any]], str]], ...] = (
    ("materials", _material_line),
    ("textures", _texture_line),
    ("lights", lambda e: f"{e['name'] or '(no name)'}: {e['type']}, {_point(e['value'])} {e['unit']}"),
    ("cameras", _camera_line),
    ("clips", lambda e: f"{e['name'] or '(no name)'}: {e['seconds']:g} s, {e['tracks']} tracks"),
)
