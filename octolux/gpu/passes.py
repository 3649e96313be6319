"""Passes: a shader with declared bindings. A pass knows what it reads and writes; it is built once, run every frame."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import wgpu

from .bindings import BindGroup, Binding
from .device import Device
from .layout import Struct
from .shaders import compile_module, compose


class _Pass:
    """What compute and render passes share: the shader module, its bind groups, and the reads and writes."""

    def __init__(
        self, device: Device, name: str, source: str, bindings: Sequence[Binding], structs: Iterable[Struct],
        shared: BindGroup | None, visibility: int, values: dict[str, Any],
    ):  # fmt: skip
        self.device, self.name, self.shared = device, name, shared
        self.own = BindGroup(bindings, structs, visibility)
        groups = [self.own] + ([shared] if shared else [])
        declared: dict[str, None] = {}  # a struct that two groups name is declared once
        for index, group in enumerate(groups):
            declared.update(dict.fromkeys(group.header(index)))
        module = compile_module(device.wgpu, name, compose(source, declared, **values))
        layout = device.wgpu.create_pipeline_layout(bind_group_layouts=[g.layout(device) for g in groups])
        self.module, self.pipeline_layout = module, layout

    @property
    def reads(self) -> list[str]:
        return [b.name for b in self._bindings() if b.access != "write"]

    @property
    def writes(self) -> list[str]:
        return [b.name for b in self._bindings() if b.access != "read"]

    def _bindings(self) -> Iterable[Binding]:
        return (*self.own.bindings, *(self.shared.bindings if self.shared else ()))

    def _bind(
        self, encoder: Any, resources: dict[str, Any], shared: dict[str, Any] | None, offsets: Sequence[int] = ()
    ) -> None:
        encoder.set_bind_group(0, self.own.group(self.device, resources), offsets)
        if self.shared:
            encoder.set_bind_group(1, self.shared.group(self.device, shared or {}))


class ComputePass(_Pass):
    """A compute shader whose entry point is `main`.

    source: the WGSL file, from the package's folder. bindings: group 0. shared: group 1, the same for several passes.
    workgroup: threads per workgroup; the template sees it as `workgroup`. values: further names for the template.
    """

    def __init__(
        self, device: Device, name: str, source: str, bindings: Sequence[Binding], *, structs: Iterable[Struct] = (),
        shared: BindGroup | None = None, workgroup: tuple[int, int, int] = (8, 8, 1), **values: Any,
    ):  # fmt: skip
        values["workgroup"] = ", ".join(map(str, workgroup))
        super().__init__(device, name, source, bindings, structs, shared, wgpu.ShaderStage.COMPUTE, values)
        self.workgroup = workgroup
        stage = {"module": self.module, "entry_point": "main"}
        self.pipeline = device.wgpu.create_compute_pipeline(label=name, layout=self.pipeline_layout, compute=stage)

    def run(self, stage: Any, threads: tuple[int, ...], shared: dict[str, Any] | None = None, **resources: Any) -> None:
        """Dispatch at least `threads` threads (x[, y[, z]]) inside profiler stage `stage`."""
        self.run_many(stage, threads, [resources], shared)

    def run_indirect(self, stage: Any, arguments: Any, **resources: Any) -> None:
        """Dispatch as many workgroups (x, y, z) as the first three words of the buffer `arguments` say."""
        encoder = stage.begin_compute_pass(self.name)
        encoder.set_pipeline(self.pipeline)
        self._bind(encoder, resources, None)
        encoder.dispatch_workgroups_indirect(arguments, 0)
        encoder.end()

    def run_many(
        self, stage: Any, threads: tuple[int, ...], resources: Sequence[dict[str, Any]], shared: Any = None
    ) -> None:
        """One dispatch for each of `resources`, in order, inside one compute pass; each sees what the former wrote."""
        counts = [-(-t // w) for t, w in zip((*threads, 1, 1), self.workgroup, strict=False)]
        encoder = stage.begin_compute_pass(self.name)
        encoder.set_pipeline(self.pipeline)
        for each in resources:
            self._bind(encoder, each, shared)
            encoder.dispatch_workgroups(*counts)
        encoder.end()


class RasterPass(_Pass):
    """A vertex and fragment shader that draws triangles into a depth buffer (reverse z) and one optional colour target.

    Entry points are `vertex` and `fragment`; without `color_format` and `fragment` it only writes depth.
    cull: leave out what shows its back.  mirrored: for views in which triangles change their winding.
    """

    def __init__(
        self, device: Device, name: str, source: str, bindings: Sequence[Binding], *, color_format: str | None,
        fragment: bool, cull: bool, mirrored: bool = False, structs: Iterable[Struct] = (),
        shared: BindGroup | None = None, **values: Any,
    ):  # fmt: skip
        visibility = wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT
        super().__init__(device, name, source, bindings, structs, shared, visibility, values)
        targets = [{"format": color_format}] if color_format else []
        stage = {"module": self.module, "entry_point": "fragment", "targets": targets}
        self.pipeline = device.wgpu.create_render_pipeline(
            label=name,
            layout=self.pipeline_layout,
            vertex={"module": self.module, "entry_point": "vertex", "buffers": []},
            primitive={
                "topology": "triangle-list", "cull_mode": "back" if cull else "none",
                "front_face": "cw" if mirrored else "ccw",
            },
            depth_stencil={"format": "depth32float", "depth_write_enabled": True, "depth_compare": "greater"},
            fragment=stage if fragment or color_format else None,
        )

    def bind(
        self, encoder: Any, shared: dict[str, Any] | None = None, offsets: Sequence[int] = (), **resources: Any
    ) -> None:
        """Make this the current pipeline of the render pass `encoder`. offsets: bytes, of the windows in order."""
        encoder.set_pipeline(self.pipeline)
        self._bind(encoder, resources, shared, offsets)
