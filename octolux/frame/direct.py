"""Direct light with shadows, towards the camera: lights and sky."""

from __future__ import annotations

from typing import Any

from ..gpu.bindings import Binding, sampler, storage_texture, texture, uniform
from ..gpu.device import Device
from ..gpu.passes import ComputePass
from .area_lights import AreaLightBuffers, AreaLights, area_lights
from .environment import SurroundingsMap
from .frame import Frame
from .lights import KINDS, Counts
from .medium import MEDIUM
from .shader_values import CONSTANTS
from .structs import AREA_LIGHT, ENVIRONMENT, LIGHT, SKY_PICK, VIEW, lights_binding, views_binding
from .views import CUBE_FACES

# Up to so many lights are unrolled; more would make the shader long to build.
_UNROLLED = 8
# A sample of a pixel that has many asks every fourth of the sky's lights, but no fewer than eight: each part is spread
# over all of the sky, and of fewer lights a share says little.
_SKY_PARTS, _LEAST_OF_SKY = 4, 8


class DirectLightPass:
    """The glTF BRDF under the sky, area lights, emitters and every directional, spot and point light: radiance in nits,
    and what of it the diffuse lobe reflects where the frame's targets have `direct_diffuse`.
    A pass is built for each number of lights of each kind, and kept."""

    def __init__(self, device: Device):
        self.device = device
        self._sky_pick = device.uniform("sky pick", SKY_PICK.array(1))
        self._area_lights: AreaLightBuffers | None = None  # made when there are any
        self._variants: dict[tuple, ComputePass] = {}

    def _variant(self, counts: Counts, areas: AreaLights, frame: Frame) -> ComputePass:
        medium, diffuse = frame.medium, frame.targets.direct_diffuse is not None
        shared = {name: getattr(frame.settings, name) for name in ("shadow_filter", "inverse_square")}
        key = (counts, areas.emitters, medium.has_density if medium else None, diffuse, *shared.values())
        if key not in self._variants:
            self._variants[key] = ComputePass(
                self.device, "direct light", "frame/direct.wgsl",
                [
                    views_binding(), lights_binding(), texture("surface_map", "uint"), texture("depth_map"),
                    texture("shadow_maps", "depth", "2d-array"), sampler("shadow_sampler", "non-filtering"),
                    storage_texture("direct_out", "rgba32float"),
                    *([storage_texture("diffuse_out", "rgba32float")] if diffuse else []),
                    *_soft_bindings(counts, areas),
                    *(medium.bindings if medium else ()),
                ],
                structs=[VIEW, LIGHT, ENVIRONMENT, SKY_PICK, AREA_LIGHT, *([MEDIUM] if medium else [])], shadows=True,
                diffuse=diffuse, **shared, **light_groups(counts, areas), **AreaLightBuffers.values(), **CONSTANTS,
                **(medium.values if medium else {"medium": False}),
            )  # fmt: skip
        return self._variants[key]

    def run(self, frame: Frame, shadow_sampler: Any, surroundings: SurroundingsMap) -> None:
        counts, areas = frame.lights.counts, area_lights(frame.lights.emitters)
        if not frame.sky_shines:
            counts = (*counts[:4], 0)  # the sky's lights are the last
        more = {"coarse_maps": frame.coarse_maps} if any(counts[3:]) else {}
        if counts[4]:
            step = min(_SKY_PARTS, frame.samples, max(1, counts[4] // _LEAST_OF_SKY))
            self.device.write(self._sky_pick, SKY_PICK.pack(sample=frame.sample, step=step))
            more |= {"sky_pick": self._sky_pick, **surroundings.resources}
        if areas.emitters:
            self._area_lights = self._area_lights or AreaLightBuffers(self.device)
            more |= {**self._area_lights.write(areas), "brdf_table": surroundings.resources["brdf_table"]}
        if frame.medium:
            more |= frame.medium.resources
        if frame.targets.direct_diffuse:
            more |= {"diffuse_out": frame.targets.direct_diffuse}
        with frame.profiler.stage("direct light") as stage:
            self._variant(counts, areas, frame).run(
                stage, frame.pixels, surface_map=frame.targets.surface, depth_map=frame.targets.depth,
                shadow_maps=frame.shadow_maps, shadow_sampler=shadow_sampler, direct_out=frame.targets.direct,
                views=frame.buffers["views"], lights=frame.buffers["lights"], **more,
            )  # fmt: skip


def _soft_bindings(counts: Counts, areas: AreaLights) -> list[Binding]:
    """What emitters, area lights and the sky need beside the other lights."""
    maps = [texture("coarse_maps", "depth", "2d-array")] if any(counts[3:]) else []
    sky = [uniform("sky_pick", SKY_PICK), *SurroundingsMap.bindings()] if counts[4] else []
    lamps = AreaLightBuffers.bindings() if areas.emitters else []
    return maps + sky + lamps + ([texture("brdf_table")] if lamps and not sky else [])


def light_groups(counts: Counts, areas: AreaLights) -> dict[str, Any]:
    """For templates: `groups`, for each kind in the order of the lights but the sky its name, first light, number of
    lights, first view, views of each, without emitters that stand for area lights; for each of these, in `areas`, its
    first emitter and how many; and where the emitters', the sky's and the coarse maps' lights and views begin."""
    groups: list[tuple[str, int, int, int, int]] = []
    light, view = 0, 1  # view 0 is the camera
    values: dict[str, Any] = {"emitters": counts[3], "sky": counts[4], "coarse": counts[3] + counts[4]}
    for kind, count in zip(KINDS, counts, strict=True):
        views_each = CUBE_FACES if kind in ("point", "emitter") else 1
        if kind == "emitter":
            values |= {"emitter_light": light, "coarse_view": view}
        if kind == "sky":
            values |= {"sky_first": light, "sky_view": view}
        else:
            groups.append((kind, light, areas.points if kind == "emitter" else count, view, views_each))
        light, view = light + count, view + count * views_each
    firsts = areas.packed["first"].tolist()
    return {
        **values, "groups": groups, "areas": list(zip(firsts, areas.emitters, strict=True)),
        "cube_faces": CUBE_FACES, "unrolled": sum(counts[:4]) <= _UNROLLED,
    }  # fmt: skip
