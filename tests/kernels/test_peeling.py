"""Depth-peeled layers of the camera and of lamps against NumPy rays that meet all triangles, in float64."""

from __future__ import annotations

import weakref
from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import front_camera, scene_of, small_settings
from test_gbuffer import placements, soup

from octolux.frame.structs import VPL
from octolux.gpu.profiler import Profiler
from octolux.gpu.records import read_records, read_words
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.techniques.baselines import NoTechnique
from octolux.techniques.settings import Settings

EDGE, LAYERS = 48, 4
FACING = 0.02
LAMPS = {
    "point": PointLight(position=(1.4, 0.9, 1.3), intensity=(1.0, 1.0, 1.0)),
    "spot": SpotLight(position=(0.0, 2.5, 0.3), direction=(0.1, -1.0, 0.0), intensity=(1.0, 1.0, 1.0)),
    "sun": DirectionalLight(direction=(0.2, -0.4, -1.0), illuminance=(1.0, 1.0, 1.0)),
}
CAMERAS = {"perspective": front_camera(2.5), "orthographic": front_camera(2.5, orthographic_height=3.0)}


def tangle(light=None) -> Scene:
    """Triangles of two materials, one seen from both sides, as they are, mirrored and sheared."""
    rng = np.random.default_rng(1)
    meshes = [soup(rng, 20, material) for material in (0, 1)]
    instances = [Instance(k % 2, transform=move) for k, move in enumerate(placements())]
    return scene_of(meshes, [Material(double_sided=True), Material()], instances=instances,
                    lights=[light] if light else [])  # fmt: skip


class Peeling(NoTechnique):
    """A technique that asks for layers."""

    needs = frozenset({"rsm", "surfaces"})

    def __init__(self, device, lamps: int, camera: int):
        super().__init__(device, Settings())
        self.lamp_layers, self.camera_layers = lamps, camera
        self.frame: SimpleNamespace

    def update(self, frame) -> None:
        self.frame = frame


def peeled(device, scene: Scene, camera: Camera) -> Renderer:
    renderer = Renderer(
        scene, "none", size=(EDGE, EDGE), device=device, default_light=False, exposure=0.0,
        frame_settings=small_settings(shadow_resolution=EDGE, rsm_resolution=EDGE, sky_lights=0, emitter_lights=0),
    )  # fmt: skip
    renderer.technique = Peeling(device, LAYERS, LAYERS)
    renderer.profiler = Profiler(device, "fenced")
    renderer.render(camera)
    return renderer


def seen_depths(device, frame) -> np.ndarray:
    """(LAYERS, pixels) of the camera."""
    layers = [frame.targets, *frame.camera_layers]
    return np.array([device.read_texture(layer.depth, np.float32, 1).ravel() for layer in layers])


def lamps_vpls(device, frame) -> np.ndarray:
    """(LAYERS, VPLs) of all lamps."""
    count = sum(count for _, count in frame.vpl_ranges)
    return np.stack([read_records(device, vpls, VPL, count) for vpls in (
        frame.vpls, *(layer.vpls for layer in frame.lamp_layers)
    )])  # fmt: skip


def rays(view) -> tuple[np.ndarray, np.ndarray]:
    """Through the middles of all pixels, (pixels, 3) each; directions have length 1 along the view's axis."""
    packed = view.pack()[0]
    y, x = (np.indices((EDGE, EDGE)) + 0.5).reshape(2, -1, 1)
    return tuple(packed[v] + x * packed[f"{v}_dx"] + y * packed[f"{v}_dy"] for v in ("origin", "direction"))


def layers_met(scene: Scene, view, stopped_by_backs: bool) -> tuple[np.ndarray, np.ndarray]:
    """Depths (LAYERS, pixels) of what rays meet one behind the other, 0 beyond the last; and bool (pixels,) where they
    are clear: no edge is within 1/50 pixel (rasterisers snap to 1/256), no other triangle within 1e-4 m, and none is
    met at less than 1/50, so that planes in float32 err by 2e-6 / FACING of the depth (test_gbuffer.py).

    stopped_by_backs: the first layer is the nearest of all; the others are of what is seen from its front."""
    origin, direction = rays(view)
    depths, fronts, clear = [], [], np.ones(EDGE * EDGE, bool)
    for instance in scene.instances:
        mesh, m = scene.meshes[instance.mesh], instance.transform
        two_sided, side = scene.materials[mesh.material].double_sided, np.linalg.det(m[:3, :3])
        for a, b, c in (mesh.positions.astype(np.float64) @ m[:3, :3].T + m[:3, 3])[mesh.indices]:
            normal = np.cross(b - a, c - a)
            slope = direction @ normal
            depth = ((a - origin) @ normal) / slope
            place = origin + depth[:, None] * direction - a
            second, third = np.cross(c - a, normal), np.cross(normal, b - a)
            weights = np.stack([place @ second, place @ third], axis=1) / (normal @ normal)
            edge = np.minimum(weights.min(axis=1), 1.0 - weights.sum(axis=1)).reshape(EDGE, EDGE)
            unclear = (np.abs(edge) <= 0.02 * np.hypot(*np.gradient(edge))).ravel()
            met = (edge > 0.0).ravel() & (depth > view.near)
            facing = np.abs(slope) / np.linalg.norm(normal) / np.linalg.norm(direction, axis=1)
            clear &= ~(unclear & (depth > 0.0)) & ~(met & (facing < FACING))
            depths.append(np.where(met, depth, np.inf))
            fronts.append(two_sided | (slope * side < 0.0))
    depths, fronts = np.array(depths), np.array(fronts)
    first = np.where(fronts | stopped_by_backs, depths, np.inf).min(axis=0)
    behind = np.sort(np.where(fronts & (depths > first), depths, np.inf), axis=0)[: LAYERS - 1]
    near = np.minimum(np.sort(depths, axis=0), 1e9)
    clear &= ((np.diff(near, axis=0) > 1e-4) | (near[1:] == 1e9)).all(axis=0)
    layers = np.concatenate([first[None], behind])
    return np.where(np.isfinite(layers), layers, 0.0), clear


def check(found: np.ndarray, expected: np.ndarray, clear: np.ndarray) -> None:
    """found: (LAYERS, pixels), 0 where nothing lies."""
    np.testing.assert_allclose(found[:, clear], expected[:, clear], rtol=2e-6 / FACING, atol=2e-6 / FACING)


@pytest.mark.parametrize("camera", CAMERAS)
def test_layers_of_the_camera(device, camera):
    scene = tangle()
    frame = peeled(device, scene, CAMERAS[camera]).technique.frame
    expected, clear = layers_met(scene, frame.views[0], stopped_by_backs=False)
    check(seen_depths(device, frame), expected, clear)
    assert clear.mean() > 0.5 and np.all((expected[:, clear] > 0.0).sum(axis=1) >= 5)


@pytest.mark.parametrize("lamp", LAMPS)
def test_layers_of_lamps(device, lamp):
    """In every view of the lamp; where a layer has a VPL, its surface has traits."""
    scene = tangle(LAMPS[lamp])
    frame, texels = peeled(device, scene, CAMERAS["perspective"]).technique.frame, EDGE**2
    vpls, met = lamps_vpls(device, frame), np.zeros(LAYERS)
    assert vpls.shape == (LAYERS, texels * frame.lights.main_views)
    for number, view in enumerate(frame.views[1:]):
        here = slice(number * texels, (number + 1) * texels)
        origin, _ = rays(view)
        found = np.where(vpls["area"][:, here] > 0.0, (vpls["position"][:, here] - origin) @ view.forward, 0.0)
        expected, clear = layers_met(scene, view, stopped_by_backs=True)
        check(found, expected, clear)
        met += (expected[:, clear] > 0.0).sum(axis=1)
    assert np.all(met >= 5)
    for layer, there in zip(frame.lamp_layers, vpls[1:]["area"] > 0.0, strict=True):
        assert np.array_equal(read_words(device, layer.surfaces, there.size) > 0, there)


def sheets(*materials: Material, far: float = -1.0) -> Scene:
    """Walls one behind the other, at z = 0, -0.5 and `far`, before a camera and a lamp."""
    meshes = [quad([(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], material=k) for k in range(3)]
    moves = [np.eye(4) for _ in range(3)]
    for move, z in zip(moves, (0.0, -0.5, far), strict=True):
        move[2, 3] = z
    lamp = SpotLight(position=(0.0, 0.0, 2.5), direction=(0.0, 0.0, -1.0), intensity=(1.0,) * 3, outer_angle=0.5)
    return scene_of(meshes, list(materials), instances=[Instance(k, transform=m) for k, m in enumerate(moves)],
                    lights=[lamp])  # fmt: skip


SOLID = Material(specular=0.0)


@pytest.mark.parametrize(("middle", "expected"), [
    (SOLID, [2.5, 3.0, 3.5, 0.0]),
    (Material(alpha=0.2, alpha_mode="mask"), [2.5, 3.5, 0.0, 0.0]),  # below the cutoff: not there
    (Material(alpha=0.8, alpha_mode="mask"), [2.5, 3.0, 3.5, 0.0]),
], ids=["solid", "cut out", "left"])  # fmt: skip
def test_masked_surfaces(device, middle, expected):
    """A plane across the view in float32: some roundings of a coordinate of 2.5 m."""
    frame = peeled(device, sheets(SOLID, middle, SOLID), CAMERAS["perspective"]).technique.frame
    np.testing.assert_allclose(seen_depths(device, frame)[:, EDGE * EDGE // 2], expected, rtol=1e-6)
    place = lamps_vpls(device, frame)[:, EDGE * (EDGE + 1) // 2]
    np.testing.assert_allclose(np.where(place["area"] > 0.0, 2.5 - place["position"][:, 2], 0.0), expected, rtol=1e-6)


def test_what_is_half_there(device):
    """Each place of a translucent surface is in one layer or in none, and half of them are there: of 2304 pixels, in
    which thresholds are hashed, half +- 5 standard deviations of 24."""
    frame = peeled(device, sheets(Material(alpha=0.5, alpha_mode="blend"), SOLID, SOLID), CAMERAS["perspective"])
    depths = seen_depths(device, frame.technique.frame)
    there = np.isclose(depths[0], 2.5, rtol=1e-6)
    assert abs(there.sum() - EDGE * EDGE / 2) < 5 * 24
    np.testing.assert_allclose(depths[0], np.where(there, 2.5, 3.0), rtol=1e-6)
    np.testing.assert_allclose(depths[1], np.where(there, 3.0, 3.5), rtol=1e-6)
    np.testing.assert_allclose(depths[2], np.where(there, 3.5, 0.0), rtol=1e-6)


def test_lamps_layers_are_kept_while_nothing_moves(device):
    """And follow what moves; the camera's are new in each frame."""
    scene = sheets(SOLID, SOLID, SOLID)
    renderer = peeled(device, scene, CAMERAS["perspective"])

    def peels() -> set[str]:
        renderer.render(CAMERAS["perspective"])
        return {name for name in renderer.profiler.last_frame() if name.startswith("peeled")}

    first = lamps_vpls(device, renderer.technique.frame)
    assert peels() == {"peeled G-buffer"}
    assert np.array_equal(lamps_vpls(device, renderer.technique.frame), first)
    scene.instances = sheets(SOLID, SOLID, SOLID, far=-1.5).instances
    assert peels() == {"peeled G-buffer", "peeled RSMs"}
    place = lamps_vpls(device, renderer.technique.frame)[2, EDGE * (EDGE + 1) // 2]
    np.testing.assert_allclose(place["position"][2], -1.5, rtol=1e-6)


@pytest.mark.parametrize("other", ["one layer", "no RSMs"])
def test_layers_go_with_who_asked_for_them(device, other):
    """And are there again for who asks next."""
    renderer = peeled(device, sheets(SOLID, SOLID, SOLID), CAMERAS["perspective"])
    depths = seen_depths(device, renderer.technique.frame)
    asking, pass_of = renderer.technique, weakref.ref(renderer._peeling)
    renderer.technique = Peeling(device, 1, 1) if other == "one layer" else NoTechnique(device, Settings())
    renderer.render(CAMERAS["perspective"])
    assert pass_of() is None
    renderer.technique = asking
    renderer.render(CAMERAS["perspective"])
    assert np.array_equal(seen_depths(device, asking.frame), depths) and depths[2].any()
