"""Ambient occlusion in screen space: its cost, its error against rays through the scene, and how steady it is."""

from __future__ import annotations

import statistics
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

import octolux
from octolux.frame.ambient_occlusion import AmbientOcclusion
from octolux.frame.frame import Frame, FrameSettings
from octolux.picture import Picture
from octolux.raytracing.bvh import Bvh
from octolux.raytracing.query import RayQuery, packed_rays
from octolux.renderer import Renderer
from octolux.scene.cameras import Camera
from octolux.scene.default_camera import chosen_camera
from octolux.simulator.gtao import FALLOFF, GOLDEN

from .lab import device, milliseconds, submitted
from .registry import at_most, figure

SIZE, CELLS = (640, 360), 32
"""Pixels; and the radius is a cell of a volume of so many cells along the scene's longest side."""
SETTINGS: dict[str, dict[str, Any]] = {
    "default": {}, "half": {"slices": 4, "steps": 8, "resolution": 2},
    "low": {"slices": 2, "steps": 4, "resolution": 2},
    "fine": {"slices": 8, "steps": 16}, "without_noise": {"filtered": False},
    "fine_without_noise": {"slices": 8, "steps": 16, "filtered": False},
}  # fmt: skip
ROUNDS, STRIDE, RAYS, MOVES = 9, 4, 256, 12


@dataclass(eq=False)
class View:
    """A frame of a scene without indirect light, its picture, and the radius, metres."""

    renderer: Renderer
    frame: Frame
    picture: Picture
    radius: float


def seen(renderer: Renderer, camera: Camera | None = None) -> View:
    """What `renderer` sees through `camera`, kept for passes that read its G-buffer."""
    frames: list[Frame] = []
    shade = renderer.technique.shade

    def watched(frame: Frame) -> None:
        frames.append(frame)
        shade(frame)

    renderer.technique.shade = watched  # type: ignore[method-assign]
    picture = renderer.render(camera)
    renderer.technique.shade = shade  # type: ignore[method-assign]
    low, high = frames[0].world_box
    return View(renderer, frames[0], picture, float((high - low).max()) / CELLS)


def plain_renderer(name: str) -> Renderer:
    settings = FrameSettings(shadow_resolution=64, rsm_resolution=32, sky_lights=0, emitter_lights=0)
    return Renderer(octolux.load(name), "none", size=SIZE, exposure=0.0, device=device(), frame_settings=settings)


@cache
def passes() -> dict[str, AmbientOcclusion]:
    return {name: AmbientOcclusion(device(), **values) for name, values in SETTINGS.items()}


def visibility(ao: AmbientOcclusion, view: View) -> np.ndarray:
    """float32 (height, width)."""
    run(ao, view)
    return device().read_texture(ao.visibility, np.float32, 1)[..., 0]


def run(ao: AmbientOcclusion, view: View) -> None:
    with submitted() as stage:
        ao.run(stage, view.frame, view.radius)
    device().wait()


def traced(view: View, rays: int = RAYS) -> tuple[np.ndarray, np.ndarray]:
    """Ambient visibility by rays, at every STRIDE-th pixel where something is seen: (pixels,); and its variance.

    Directions are spread like the cosine over the shading normal; those below the surface are left out.
    """
    every = (slice(STRIDE // 2, None, STRIDE),) * 2
    layers, there = view.picture.layers, view.picture.mask[every]
    arrays = (layers["position"], layers["normal"], view.picture.geometric_normal)
    position, normal, geometric = (a[every][there].astype(np.float64) for a in arrays)
    aside = 1e-4 * layers["depth"][every][there][:, None] * geometric
    bvh = Bvh(device())
    bvh.sync(view.renderer.gpu_scene)
    query, rng = RayQuery(device(), view.renderer.gpu_scene, bvh), np.random.default_rng(0)
    turn, sums = rng.random(len(position)), np.zeros((3, len(position)))
    for i in range(rays):
        directions = _cosine(normal, (i + rng.random(len(position))) / rays, turn + i * GOLDEN)
        hits = query(packed_rays(position + aside, directions, 0.0, view.radius))
        t = np.where(hits["id"] > 0, hits["t"], np.inf)
        open_share = np.clip((t / view.radius - (1.0 - FALLOFF)) / FALLOFF, 0.0, 1.0)
        above = np.sum(directions * geometric, axis=-1) > 0.0
        sums += above * np.stack([open_share, open_share**2, np.ones_like(t)])
    mean = sums[0] / np.maximum(sums[2], 1.0)
    return mean, (sums[1] / np.maximum(sums[2], 1.0) - mean**2) / np.maximum(sums[2], 1.0)


def _cosine(normal: np.ndarray, radius_squared: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Directions over normals (n, 3) whose points on the unit disc have this squared radius and turn, in circles."""
    helper = np.where(np.abs(normal[:, :1]) < 0.5, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    tangent = np.cross(normal, helper)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    across, up = np.cos(2.0 * np.pi * turn)[:, None], np.sin(2.0 * np.pi * turn)[:, None]
    on_disc = np.sqrt(radius_squared)[:, None] * (across * tangent + up * np.cross(normal, tangent))
    return on_disc + np.sqrt(1.0 - radius_squared)[:, None] * normal


@figure("clpv_ao_cost", group="clpv_ao", unit="ms")
def cost() -> dict[str, float]:
    """Ambient occlusion of the atrium at 640x360, and its share of a frame of uniform-lpv: medians, taking turns."""
    view = seen(plain_renderer("atrium"))
    lit = Renderer(octolux.load("atrium"), "uniform-lpv", size=SIZE, exposure=0.0, device=device())
    times: dict[str, list[float]] = {name: [] for name in [*SETTINGS, "frame"]}
    for _ in range(ROUNDS + 2):
        lit.forget()  # a frame in which light moves
        times["frame"].append(milliseconds(lambda: (lit.render(), device().wait())))
        for name, ao in passes().items():
            times[name].append(milliseconds(lambda ao=ao: run(ao, view)))
    found = {name: statistics.median(values[2:]) for name, values in times.items()}
    shares = {f"{name}_percent": 100.0 * found[name] / (found["frame"] + found[name]) for name in SETTINGS}
    return {**found, **shares}


SCENES = ("atrium", "cornell-box", "conference")


# What it is for: without it that RMSE is the error, of which it must take away more than half.
@figure("clpv_ao_error", group="clpv_ao", bound={f"{scene}.default_left": at_most(0.5) for scene in SCENES})
def error() -> dict[str, float]:
    """Mean ambient visibility within a cell, by rays and from the depth buffer; RMSE without the rays' noise."""
    found = {}
    for scene in SCENES:
        view = seen(plain_renderer(scene))
        expected, variance = traced(view)
        there = view.picture.mask[STRIDE // 2 :: STRIDE, STRIDE // 2 :: STRIDE]
        found[f"{scene}.radius_m"], found[f"{scene}.rays_mean"] = view.radius, expected.mean()
        found[f"{scene}.no_occlusion_rmse"] = np.sqrt(np.mean((1.0 - expected) ** 2))
        for name, ao in passes().items():
            off = visibility(ao, view)[STRIDE // 2 :: STRIDE, STRIDE // 2 :: STRIDE][there] - expected
            found[f"{scene}.{name}_mean"] = expected.mean() + off.mean()
            found[f"{scene}.{name}_rmse"] = np.sqrt(max(np.mean(off**2) - variance.mean(), 0.0))
            found[f"{scene}.{name}_left"] = found[f"{scene}.{name}_rmse"] / found[f"{scene}.no_occlusion_rmse"]
    return found


@figure("clpv_ao_steadiness", group="clpv_ao")
def steadiness() -> dict[str, float]:
    """Change of visibility at fixed points of the atrium from frame to frame; the camera slides a tenth of a radius."""
    renderer = plain_renderer("atrium")
    start = chosen_camera(renderer.scene, None, SIZE[0] / SIZE[1])
    first = seen(renderer, start)
    points = first.picture.layers["position"][first.picture.mask][::7].astype(np.float64)
    before: dict[str, np.ndarray] = {}
    changes: dict[str, list[np.ndarray]] = {name: [] for name in SETTINGS}
    for move in range(MOVES):
        shift = np.eye(4)
        shift[:3, 3] = 0.1 * move * first.radius * start.transform[:3, 0]
        view = seen(renderer, replace(start, transform=shift @ start.transform))
        row, column, shown = _pixels(view, points)
        for name, ao in passes().items():
            now = np.where(shown, visibility(ao, view)[row, column], np.nan)
            if move:
                change = np.abs(now - before[name])
                changes[name].append(change[np.isfinite(change)])
            before[name] = now
    found = {}
    for name, each in changes.items():
        all_changes = np.concatenate(each)
        found[f"{name}_mean"] = all_changes.mean()
        found[f"{name}_median"], found[f"{name}_99th"] = np.quantile(all_changes, [0.5, 0.99])
    return found


def _pixels(view: View, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows and columns where points (n, 3) lie, and whether they are seen there."""
    clip = np.c_[points, np.ones(len(points))] @ view.frame.views[0].view_projection.T
    column = np.floor((0.5 + 0.5 * clip[:, 0] / clip[:, 3]) * SIZE[0]).astype(int)
    row = np.floor((0.5 - 0.5 * clip[:, 1] / clip[:, 3]) * SIZE[1]).astype(int)
    inside = (row >= 0) & (row < SIZE[1]) & (column >= 0) & (column < SIZE[0])
    row, column = np.clip(row, 0, SIZE[1] - 1), np.clip(column, 0, SIZE[0] - 1)
    off = np.linalg.norm(view.picture.layers["position"][row, column] - points, axis=-1)
    return row, column, inside & (off < 0.1 * view.radius)
