"""Area lights and the sky beside closed forms: irradiance, gloss, the Cornell box, and what the direct light costs.

`points` are the emitters that stood for area lights before they were lit by linearly transformed cosines, and still
stand for glowing surfaces: the same rectangle as a mesh that glows, with as many lights and shadow maps.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np

import octolux
from octolux.compare.metrics import relative_errors
from octolux.frame.frame import FrameSettings
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.lights import AreaLight
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.simulator import brdf, direct, ltc

from .comparison_set import VIEWS, reference, scene_of
from .lab import device
from .registry import Bound, at_most, figure, within

DISTANCES = (0.1, 0.3, 1.0, 3.0, 10.0)
"""Of the square, in edges."""
TILTS, OFFSETS = (0.0, 0.9, 0.5 * pi), (0.0, 0.7, 2.0)
"""Receivers turned away, up to where the horizon cuts the square in two; the square's displacement, edges."""
ROUGHNESS = (0.2, 0.3, 0.5, 0.7, 1.0)
"""The quadrature cannot resolve smoother floors in a few seconds; the fit's error goes to 0 there."""
VIEWS_OF_GLOSS = {"steep": 2.0, "slanted": 1.0, "grazing": 0.3}
"""Height of an eye 2 m before the middle of a floor, m: n.v is 0.7, 0.45 and 0.15 there."""
WAYS = ("ltc", "points")
_FRAMES = 15


def square(height: float, x: float = 0.0) -> AreaLight:
    """1 m by 1 m, 1 nit, shining down."""
    corners = ((x - 0.5, height, -0.5), (x + 0.5, height, -0.5), (x + 0.5, height, 0.5), (x - 0.5, height, 0.5))
    return AreaLight(corners=corners, radiance=(1.0, 1.0, 1.0))


def as_mesh(scene: Scene) -> Scene:
    """The scene with its area lights as surfaces that glow."""
    lamps = [light for light in scene.lights if isinstance(light, AreaLight)]
    meshes, count = len(scene.meshes), len(scene.materials)
    glow = [Material(emissive=lamp.radiance, base_color=(0.0,) * 3, specular=0.0) for lamp in lamps]
    return replace(
        scene, lights=[light for light in scene.lights if not isinstance(light, AreaLight)],
        meshes=[*scene.meshes, *(quad(lamp.corners, material=count + n) for n, lamp in enumerate(lamps))],
        instances=[*scene.instances, *(Instance(meshes + n) for n in range(len(lamps)))],
        materials=[*scene.materials, *glow],
    )  # fmt: skip


def _renderer(scene: Scene, size: tuple[int, int], profile: bool = False, **settings: int) -> Renderer:
    chosen = FrameSettings(**settings)
    return Renderer(
        scene, "none", size=size, exposure=0.0, device=device(), frame_settings=chosen, profile=profile,
        default_light=False,
    )  # fmt: skip


def _plate(tilt: float) -> tuple[Scene, Camera]:
    """A white Lambertian plate of 4 cm about the origin, turned about z, and a camera just over it."""
    c, s, h = 0.02 * np.cos(tilt), 0.02 * np.sin(tilt), 0.02
    mesh = quad([(-c, s, h), (c, -s, h), (c, -s, -h), (-c, s, -h)])
    normal = np.array([np.sin(tilt), np.cos(tilt), 0.0])
    eye = Camera.look_at(0.05 * normal, (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), orthographic_height=0.02)
    return Scene(meshes=[mesh], instances=[Instance(0)], materials=[Material(specular=0.0)]), eye


@figure("clpv_area_irradiance", group="clpv_area", unit="relative",
        bound={f"ltc.{d:g}_edges{at}": at_most(0.02) for d in DISTANCES for at in ("", "_on_axis")})  # fmt: skip
def area_irradiance() -> dict[str, float]:
    """Irradiance under a square light against Lambert's formula, by distance: the largest error of any receiver, flat,
    tilted or cut by the horizon, on the axis and beside it; and of the flat one on the axis."""
    plates = [_plate(tilt) for tilt in TILTS]
    renderers = [_renderer(scene, (4, 4), coarse_resolution=256) for scene, _ in plates]
    found: dict[str, float] = {}
    for distance in DISTANCES:
        for number, ((scene, eye), renderer) in enumerate(zip(plates, renderers, strict=True)):
            for offset in OFFSETS:
                lit = replace(scene, lights=[square(distance, offset)])
                for way in WAYS:
                    renderer.scene = lit if way == "ltc" else as_mesh(lit)
                    error = _error(renderer, eye, square(distance, offset))
                    name = f"{way}.{distance:g}_edges"
                    found[name] = max(found.get(name, 0.0), error)
                    if number == 0 and offset == 0.0:
                        found[f"{name}_on_axis"] = error
    return {name: found[name] for name in sorted(found, key=lambda name: name.split(".")[0])}


def _error(renderer: Renderer, eye: Camera, light: AreaLight) -> float:
    """Largest relative error of a pixel."""
    picture = renderer.render(eye)
    position, normal = (picture.layers[name].astype(np.float64) for name in ("position", "normal"))
    expected = direct.area_light_irradiance(light, position, normal) / pi
    assert picture.mask.all()
    return float(np.abs(picture.layers["direct"] / expected - 1.0).max())


@figure("clpv_area_sky", group="clpv_area", unit="of pi L", bound=within(1.0, 0.02))
def area_sky() -> dict[str, float]:
    """Irradiance on an open plane under a uniform sky over pi L: mean, flat and turned by 0.9 rad."""
    found = {}
    for name, tilt in (("flat", 0.0), ("tilted", 0.9)):
        scene, eye = _plate(tilt)
        picture = _renderer(replace(scene, environment=Environment((1.0, 1.0, 1.0))), (4, 4)).render(eye)
        found[name] = float(picture.layers["direct"].mean())
    return found


def _gloss(material: Material, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Radiance of pixels (n, 3) of a floor that mirrors an upright rectangle, on the device and of the BRDF itself by
    quadrature."""
    floor = quad([(-4, 0, 4), (4, 0, 4), (4, 0, -4), (-4, 0, -4)])
    corners = ((-0.5, 0.05, -1.0), (0.5, 0.05, -1.0), (0.5, 1.05, -1.0), (-0.5, 1.05, -1.0))
    light = AreaLight(corners=corners, radiance=(1.0, 1.0, 1.0))
    scene = Scene(meshes=[floor], instances=[Instance(0)], materials=[material], lights=[light])
    eye = Camera.look_at((0.0, height, 2.0), (0.0, 0.0, 0.0), vertical_fov=0.3)
    picture = _renderer(scene, (6, 6), coarse_resolution=256).render(eye)
    position, normal = (picture.layers[name].astype(np.float64) for name in ("position", "normal"))
    surface = brdf.surface(material.base_color, material.metallic, round(material.roughness * 255) / 255)
    expected = []
    for at in zip(*np.nonzero(picture.mask), strict=True):
        to_eye = (eye.position - position[at]) / np.linalg.norm(eye.position - position[at])
        expected.append(ltc.quadrature(light, position[at], normal[at], to_eye, surface, 384))
    return picture.layers["direct"][picture.mask].astype(np.float64), np.array(expected)


@figure("clpv_area_gloss", group="clpv_area", unit="of the mean")
def area_gloss() -> dict[str, float]:
    """Light of an upright rectangle that floors of metal and of black dielectric reflect, against the BRDF by
    quadrature: root mean square error over the mean, by angle of view and roughness. It is the fit's own error."""
    found = {}
    for name, base, metallic in (("metal", (1.0, 1.0, 1.0), 1.0), ("dielectric", (0.0, 0.0, 0.0), 0.0)):
        for view, height in VIEWS_OF_GLOSS.items():
            for roughness in ROUGHNESS:
                material = Material(base_color=base, metallic=metallic, roughness=roughness)
                made, expected = _gloss(material, height)
                error = np.sqrt(np.mean(np.square(made - expected))) / expected.mean()
                found[f"{name}.{view}.{roughness:g}"] = float(error)
    return found


@figure("clpv_area_cornell", group="clpv_area",
        bound={"ltc.ratio": within(1.0, 0.02), "points.ratio": Bound()})  # fmt: skip
def area_cornell() -> dict[str, float]:
    """Direct light of the Cornell box with its area light against the path-traced one: ratio of means, relative RMSE
    and the same without the 3 % of pixels that err most, which are the shadows' steps."""
    view = VIEWS["cornell_area"]
    truth = reference(view)
    height, width = truth.mask.shape
    found = {}
    for way in WAYS:
        scene = scene_of(view) if way == "ltc" else as_mesh(scene_of(view))
        picture = _renderer(scene, (width, height)).render(view.camera)
        wanted = truth.pictures["direct"]
        errors = relative_errors(picture.layers["direct"], wanted, wanted, truth.mask & picture.mask, wanted)
        found |= {f"{way}.{name}": value for name, value in errors.items() if value is not None}
    return found


@figure("clpv_area_cost", group="clpv_area", unit={"cornell.ratio": "x"} | dict.fromkeys(
        ("cornell.ltc", "cornell.points", "conference"), "ms"))  # fmt: skip
def area_cost() -> dict[str, float]:
    """Direct light at 640x360, ms: the Cornell box by both ways, taking turns, and the conference, which has no area
    light and whose shader has nothing of them: medians, also of the two ways' ratios frame by frame."""
    view = VIEWS["cornell_area"]
    scenes = {"cornell.ltc": (scene_of(view), view.camera), "cornell.points": (as_mesh(scene_of(view)), view.camera),
              "conference": (octolux.load("conference").at(0.0), "door")}  # fmt: skip
    renderers = {name: _renderer(scene, (640, 360), profile=True) for name, (scene, _) in scenes.items()}
    times: dict[str, list[float]] = {name: [] for name in scenes}
    for _ in range(_FRAMES + 2):
        for name, renderer in renderers.items():
            renderer.profiler.clear()
            renderer.render(scenes[name][1])
            rows = renderer.profiler.stages()
            times[name].append(next(row["median_ms"] for row in rows if row["name"] == "direct light"))
    steady = {name: np.array(values[2:]) for name, values in times.items()}
    ratio = float(np.median(steady["cornell.ltc"] / steady["cornell.points"]))
    return {name: float(np.median(values)) for name, values in steady.items()} | {"cornell.ratio": ratio}
