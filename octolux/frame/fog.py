"""Fog: light that the medium scatters towards the camera (single scattering, CLPV 7), and what it lets through."""

from __future__ import annotations

from typing import Any

from ..gpu.bindings import Binding, storage_texture, texture, uniform
from ..gpu.device import Device
from ..gpu.layout import Struct
from ..gpu.passes import ComputePass
from .area_lights import AreaLights
from .direct import light_groups
from .frame import COPY, STORAGE, TEXTURE, Frame
from .lights import Counts
from .medium import MEDIUM, MediumBuffers
from .shader_values import CONSTANTS
from .structs import AREA_LIGHT, LIGHT, VIEW, lights_binding, views_binding
from .volume_light import VolumeLight

STEPS = 32
"""Steps of a path where no volume says how long they are. A step that a shadow's edge cuts is lit or dark as a whole;
over the 16 places that the dither gives a step, and which the filter brings together, it is wrong by at most half a
place: 1 / (2 * 16 * 32) = 1/1024 of the path. With four edges on a path that is a step of an 8-bit picture."""

MOST_STEPS = 256
"""Of a path through a volume; where its cells would ask for more, steps are longer."""

# step: in cells of the light volume and of the density.  sample: which of each pixel's samples is drawn.
FOG = Struct("FogSettings", step="f32", sample="u32")


class FogPass:
    """Marches along some of the pixels' paths, filters, and brings the result to all pixels. Variants by the lights,
    the kind of medium and the technique's volume are built when first needed."""

    def __init__(self, device: Device):
        self.device = device
        self.medium = MediumBuffers(device)
        self._settings = device.uniform("fog settings", FOG.array(1))
        self._passes: dict[tuple, ComputePass] = {}
        self._pictures: dict[str, Any] = {}

    def run(self, frame: Frame) -> None:
        """Set and fill `frame.inscattered` and `frame.transmittance` for the present sample of each pixel."""
        self._make_room(frame)
        self.device.write(self._settings, FOG.pack(step=frame.settings.fog_step, sample=frame.sample))
        frame.inscattered, frame.transmittance = self._pictures["inscattered"], self._pictures["transmittance"]
        common = {
            "views": frame.buffers["views"], "depth_map": frame.targets.depth, **self.medium.resources,
        }  # fmt: skip
        with frame.profiler.stage("fog") as stage:
            self._march(stage, frame, common)
            self._spread(stage, "fog filter", frame, common, self._read("marched"), self._written("filtered"))
            whole = {"inscattered_out": frame.inscattered, "transmittance_out": frame.transmittance}
            self._spread(stage, "fog upsampling", frame, common, self._read("filtered"), whole)

    def _make_room(self, frame: Frame) -> None:
        """Pictures of the frame's size and of that of the marched paths."""
        width, height = frame.pixels
        block = frame.settings.fog_resolution
        few = (-(-width // block), -(-height // block))
        wanted = {"inscattered": (frame.pixels, "rgba32float"), "transmittance": (frame.pixels, "rgba32float")}
        for name in ("marched", "filtered"):
            wanted[name] = (few, "rgba32float")
            if self.medium.has_density:
                wanted[f"{name} density"] = (few, "r32float")
        for name, (size, format) in wanted.items():
            if name not in self._pictures or self._pictures[name].size[:2] != size:
                usage = STORAGE | TEXTURE | COPY
                self._pictures[name] = self.device.texture(f"fog {name}", size, format, usage=usage)

    def _read(self, name: str) -> dict[str, Any]:
        more = {"fog_density": self._pictures[f"{name} density"]} if self.medium.has_density else {}
        return {"fluence_map": self._pictures[name], **more}

    def _written(self, name: str) -> dict[str, Any]:
        more = {"density_out": self._pictures[f"{name} density"]} if self.medium.has_density else {}
        return {"fluence_out": self._pictures[name], **more}

    def _march(self, stage: Any, frame: Frame, common: dict[str, Any]) -> None:
        counts, volume, written = frame.lights.counts, frame.volume_light, self._written("marched")
        more = {"coarse_maps": frame.coarse_maps} if any(counts[3:]) else {}
        inverse_square, kind = frame.settings.inverse_square, (self.medium.has_density, volume and volume.key)
        key = ("march", frame.settings.fog_resolution, counts, inverse_square, *kind)
        if key not in self._passes:
            lights = {"inverse_square": inverse_square, **light_groups(counts, _all_points(counts))}
            values = _march_values(volume, {"coarse": bool(more), **lights})
            maps = [texture(name, "depth", "2d-array") for name in ("shadow_maps", *more)]
            self._passes[key] = self._made(
                "fog march", "frame/fog.wgsl", frame, [
                    lights_binding(), uniform("fog", FOG), *maps, *_outputs(written),
                    *(volume.bindings if volume else ()),
                ], [FOG, *(volume.structs if volume else ())], values,
            )  # fmt: skip
        self._passes[key].run(
            stage, self._pictures["marched"].size[:2], lights=frame.buffers["lights"], fog=self._settings,
            shadow_maps=frame.shadow_maps, **common, **more, **written, **(volume.resources if volume else {}),
        )  # fmt: skip

    def _spread(
        self, stage: Any, label: str, frame: Frame, common: dict[str, Any], read: dict[str, Any],
        written: dict[str, Any],
    ) -> None:  # fmt: skip
        key = (label, frame.settings.fog_resolution, self.medium.has_density)
        if key not in self._passes:
            file = "frame/fog_filter.wgsl" if label == "fog filter" else "frame/fog_upsample.wgsl"
            self._passes[key] = self._made(label, file, frame, [*map(texture, read), *_outputs(written)], [], {})
        size = next(iter(written.values())).size[:2]
        self._passes[key].run(stage, size, **common, **read, **written)

    def _made(
        self, label: str, file: str, frame: Frame, bindings: list[Binding], structs: list[Struct],
        values: dict[str, Any],
    ) -> ComputePass:  # fmt: skip
        return ComputePass(
            self.device, label, file, [views_binding(), texture("depth_map"), *self.medium.bindings, *bindings],
            structs=[VIEW, LIGHT, MEDIUM, *structs],
            **{**CONSTANTS, **values, **self.medium.values, "resolution": frame.settings.fog_resolution},
        )  # fmt: skip


def _all_points(counts: Counts) -> AreaLights:
    """In the air every emitter counts for itself, whatever it stands for."""
    return AreaLights(AREA_LIGHT.array(0), (), counts[3])


def _outputs(written: dict[str, Any]) -> list[Binding]:
    return [storage_texture(name, picture.format) for name, picture in written.items()]


def _march_values(volume: VolumeLight | None, lights: dict[str, Any]) -> dict[str, Any]:
    """For frame/fog.wgsl: a volume's names may not hide ours."""
    given = {"volume": volume is not None, "volume_file": volume.file if volume else ""}
    own = {"steps": STEPS, "most_steps": MOST_STEPS, "shadows": False}
    return {**(volume.values if volume else {}), **lights, **given, **own}
