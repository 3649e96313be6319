"""Reflective shadow maps (Dachsbacher and Stamminger 2005): the lit surfaces as VPLs."""

from __future__ import annotations

from typing import Any

from ..gpu.bindings import texture, uniform
from ..gpu.device import Device, DeviceError
from ..gpu.limits import DEFAULT_LIMITS
from ..gpu.passes import ComputePass
from ..gpu.records import record_texture, records_out, word_texture, words_out
from ..gpu_scene.gpu_scene import GpuScene
from ..simulator.rsm import MIN_COSINE
from .frame import Frame
from .medium import MEDIUM, MediumBuffers
from .settings import COARSE_BLOCK, FrameSettings
from .shader_values import CONSTANTS, surface_values
from .shadows import ShadowMapPass
from .structs import LIGHT, RSM_SET, VIEW, VPL, lights_binding, views_binding
from .traits import TRAIT_VALUES


class RSMPass:
    """Takes one texel of each block of the shadow maps and makes it a VPL that reflects what the whole block receives:
    flux = albedo * intensity * solid angle of the block (OLPV 3.3), or albedo * illuminance * its area across a
    directional light, or one without falloff. Its area is the surface that the block covers (simulator/rsm.py).

    VPLs are made again only when maps were drawn since, or the light that they reflect or their traits are other.

    surfaces: also write the traits of each VPL's surface (traits.py)."""

    def __init__(self, device: Device, scene: GpuScene, settings: FrameSettings, surfaces: bool = False):
        self.device, self._with_surfaces = device, surfaces
        self._vpls: Any = None
        self._surfaces: Any = None
        self._room = 0
        self._made_of: tuple = ()
        stride = settings.shadow_resolution // settings.rsm_resolution
        self._edges = (settings.rsm_resolution, settings.coarse_resolution // COARSE_BLOCK)
        self._scene, self._blocks = scene, (stride, COARSE_BLOCK)
        self._variants: dict[tuple[int, bool | None, bool], ComputePass] = {}
        self._sets = [device.uniform("RSM set", RSM_SET.array(1)) for _ in self._blocks]
        self._sets_of_views: list[Any] = []

    def _variant(self, number: int, frame: Frame) -> ComputePass:
        medium, inverse_square = frame.medium, frame.settings.inverse_square
        key = (number, medium.has_density if medium else None, inverse_square)
        if key not in self._variants:
            self._variants[key] = self._made(self._edges[number], self._blocks[number], medium, inverse_square)
        return self._variants[key]

    def _made(
        self, resolution: int, stride: int, medium: MediumBuffers | None, inverse_square: bool
    ) -> ComputePass:  # fmt: skip
        outputs = [records_out("vpls", VPL), *([words_out("surfaces")] if self._with_surfaces else [])]
        return ComputePass(
            self.device, "RSM", "frame/rsm.wgsl",
            [
                views_binding(), lights_binding(), uniform("maps", RSM_SET),
                texture("shadow_ids", "uint", "2d-array"), *outputs,
                *(medium.bindings if medium else ()),
            ],
            structs=[VIEW, LIGHT, VPL, RSM_SET, *([MEDIUM] if medium else [])], shared=self._scene.bindings,
            shadows=False, surfaces=self._with_surfaces, resolution=resolution, stride=stride, min_cosine=MIN_COSINE,
            inverse_square=inverse_square, **CONSTANTS, **TRAIT_VALUES, **surface_values(self._scene),
            **(medium.values if medium else {"medium": False}),
        )  # fmt: skip

    def run(self, frame: Frame, shadow_maps: ShadowMapPass) -> None:
        """Fill `frame.vpls`, with surfaces `frame.vpl_surfaces`, and say in `frame.vpl_ranges` and `frame.vpl_widths`
        where those of each light lie."""
        layers = (frame.lights.main_views, len(frame.lights.views) - frame.lights.main_views)
        counts = [n * edge**2 for n, edge in zip(layers, self._edges, strict=True)]
        self._make_room(frame, sum(counts))
        frame.vpls, frame.vpl_surfaces = self._vpls, self._surfaces
        frame.vpl_ranges, frame.vpl_widths = self._ranges(frame)
        if not any(layers) or self._are_kept(frame, shadow_maps):
            return
        places = ((1, 0), (1 + layers[0], counts[0]))
        with frame.profiler.stage("RSM surfaces") as stage:
            for number, maps in enumerate((shadow_maps.main, shadow_maps.coarse)):
                first_view, first_vpl = places[number]
                self.device.write(self._sets[number], RSM_SET.pack(
                    first_view=first_view, first_vpl=first_vpl, emitters=number
                ))  # fmt: skip
                if layers[number]:
                    self._write(stage, frame, number, layers[number], self._sets[number], maps.ids, self._vpls,
                                self._surfaces)  # fmt: skip

    def of_view(self, stage: Any, frame: Frame, view: int, ids: Any, vpls: Any, surfaces: Any) -> None:
        """Write where those of one lamp's view are in `frame.vpls` the same of other triangles `ids` (an array of one
        layer), into `vpls` and `surfaces`. view: its number among the views that have maps of full resolution."""
        if view == len(self._sets_of_views):
            self._sets_of_views.append(self.device.uniform("RSM set", RSM_SET.array(1)))
        place, first = self._sets_of_views[view], view * self._edges[0] ** 2
        self.device.write(place, RSM_SET.pack(first_view=1 + view, first_vpl=first, emitters=0))
        self._write(stage, frame, 0, 1, place, ids, vpls, surfaces)

    def _write(
        self, stage: Any, frame: Frame, number: int, layers: int, place: Any, ids: Any, vpls: Any, surfaces: Any
    ) -> None:  # fmt: skip
        """Of set `number`, from as many layers of `ids`. place: uniform buffer of RSM_SET."""
        edge = self._edges[number]
        others = {"vpls": vpls, **({"surfaces": surfaces} if self._with_surfaces else {})}
        if frame.medium:
            others |= frame.medium.resources
        self._variant(number, frame).run(
            stage, (edge, edge, layers), frame.gpu_scene.resources, views=frame.buffers["views"],
            lights=frame.buffers["lights"], maps=place, shadow_ids=ids, **others,
        )  # fmt: skip

    def _are_kept(self, frame: Frame, shadow_maps: ShadowMapPass) -> bool:
        """Whether the VPLs are what would be made: all that they are made of is as it was."""
        lights = (frame.lights.counts, frame.lights.packed.tobytes(), frame.settings.inverse_square)
        moving = frame.gpu_scene.is_moving.tobytes()  # one of the traits
        before, self._made_of = self._made_of, (shadow_maps.drawings, *lights, moving, frame.scene.medium, self._vpls)
        return before == self._made_of

    def _make_room(self, frame: Frame, vpls: int) -> None:
        size, limit = max(1, vpls) * VPL.size, DEFAULT_LIMITS["max-storage-buffer-binding-size"]
        if size > limit:
            raise DeviceError(
                f"{frame.lights.main_views} views of lights with {self._edges[0]} x {self._edges[0]} VPLs each and "
                f"{len(frame.lights.views) - frame.lights.main_views} of emitters and sky are more than the "
                f"{limit // VPL.size} VPLs that fit. Use fewer lights (a point light has six views), fewer "
                "--sky-lights or a lower --rsm-resolution."
            )
        if self._vpls is None or self._room != vpls:
            self._vpls, self._room = record_texture(self.device, "VPLs", VPL, vpls), vpls
            if self._with_surfaces:
                self._surfaces = word_texture(self.device, "VPLs' surfaces", vpls)

    def _ranges(self, frame: Frame) -> tuple[list[tuple[int, int]], list[int]]:
        """First and number of the VPLs of each light, those of its views behind one another; and how many a row has."""
        lights = frame.lights
        counts, widths = [0] * len(lights.lights), [1] * len(lights.lights)
        for number, owner in enumerate(lights.light_of_view):
            widths[owner] = self._edges[number >= lights.main_views]
            counts[owner] += widths[owner] ** 2
        return [(sum(counts[:number]), count) for number, count in enumerate(counts)], widths
