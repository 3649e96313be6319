"""Bindings: what a pass reads and writes, declared once; from it come the WGSL text and the bind group layout."""

from __future__ import annotations

import weakref
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import wgpu

from .layout import Struct


@dataclass(frozen=True)
class Binding:
    """One resource of a pass. `access` is "read", "write" or "read_write"; `layout` is its part of wgpu's entry."""

    name: str
    wgsl: str
    access: str
    layout: dict[str, Any] = field(hash=False)
    loader: str = ""  # WGSL function that reads an element of it
    window: int = 0  # bytes that are seen of a buffer which is bound at a dynamic offset; 0 is all of it


def _type_name(kind: str | Struct) -> str:
    return kind.name if isinstance(kind, Struct) else kind


def uniform(name: str, kind: str | Struct) -> Binding:
    return Binding(name, f"var<uniform> {name}: {_type_name(kind)};", "read", {"buffer": {"type": "uniform"}})


def uniform_window(name: str, kind: Struct) -> Binding:
    """One element of a buffer whose elements lie 256 bytes apart; which one is said when it is bound."""
    layout = {"buffer": {"type": "uniform", "has_dynamic_offset": True, "min_binding_size": kind.size}}
    return Binding(name, f"var<uniform> {name}: {kind.name};", "read", layout, window=kind.size)


def storage(name: str, kind: str | Struct) -> Binding:
    """A read-only array in a storage buffer; `kind` is its element."""
    text = f"var<storage, read> {name}: array<{_type_name(kind)}>;"
    return Binding(name, text, "read", {"buffer": {"type": "read-only-storage"}})


def storage_words(name: str, kind: Struct) -> Binding:
    """A read-only array of structs that the shader reads with `load_NAME(index)`, 16 bytes at a time."""
    text = f"var<storage, read> {name}: array<vec4u>;"
    return Binding(name, text, "read", {"buffer": {"type": "read-only-storage"}}, loader=kind.wgsl_loader(name))


def storage_rw(name: str, kind: str | Struct, access: str = "read_write") -> Binding:
    """A writable array in a storage buffer. WGSL has no write-only buffers; `access` may say that we only write."""
    text = f"var<storage, read_write> {name}: array<{_type_name(kind)}>;"
    return Binding(name, text, access, {"buffer": {"type": "storage"}})


def atomic_words(name: str, kind: str) -> Binding:
    """A buffer of atomic words: "i32" or "u32"."""
    text = f"var<storage, read_write> {name}: array<atomic<{kind}>>;"
    return Binding(name, text, "read_write", {"buffer": {"type": "storage"}})


_SAMPLE_TYPES = {"float": "f32", "unfilterable-float": "f32", "uint": "u32"}


def texture(name: str, sample_type: str = "unfilterable-float", dimension: str = "2d") -> Binding:
    """A sampled texture; "float" may be filtered, "depth" is compared."""
    shape = dimension.replace("-", "_")
    kind = f"texture_depth_{shape}" if sample_type == "depth" else f"texture_{shape}<{_SAMPLE_TYPES[sample_type]}>"
    layout = {"texture": {"sample_type": sample_type, "view_dimension": dimension}}
    return Binding(name, f"var {name}: {kind};", "read", layout)


def storage_texture(name: str, format: str, dimension: str = "2d", access: str = "write") -> Binding:
    """A texture without mip levels or filters, to "write" or to "read". A software adapter reads one at addresses that
    differ between threads two to three times faster than a storage buffer or a sampled texture."""
    text = f"var {name}: texture_storage_{dimension}<{format}, {access}>;"
    layout = {"storage_texture": {"access": f"{access}-only", "format": format, "view_dimension": dimension}}
    return Binding(name, text, access, layout)


def sampler(name: str, kind: str = "filtering") -> Binding:
    """A sampler: "filtering", or "comparison" for shadow maps."""
    wgsl_type = "sampler_comparison" if kind == "comparison" else "sampler"
    return Binding(name, f"var {name}: {wgsl_type};", "read", {"sampler": {"type": kind}})


_KEPT_GROUPS = 32


class BindGroup:
    """Bindings that are set together: one bind group layout, and the groups made for it.

    `structs` are the structs the bindings and their shader name. Several passes may share one BindGroup.
    """

    def __init__(self, bindings: Sequence[Binding], structs: Iterable[Struct] = (), visibility: int = 0):
        names = [b.name for b in bindings]
        if len(set(names)) != len(names):
            raise ValueError(f"a binding is declared twice: {names}")
        self.bindings = tuple(bindings)
        self.structs = tuple(structs)
        self.visibility = visibility or wgpu.ShaderStage.COMPUTE
        self._layout: Any = None
        self._groups: dict[tuple[int, ...], tuple[list[weakref.ref], Any]] = {}

    def header(self, group: int) -> list[str]:
        """WGSL declarations as group `group`."""
        lines = [s.wgsl for s in self.structs]
        lines += [f"@group({group}) @binding({i}) {b.wgsl}" for i, b in enumerate(self.bindings)]
        return lines + [b.loader for b in self.bindings if b.loader]

    def layout(self, device: Any) -> Any:
        if self._layout is None:
            entries = [{"binding": i, "visibility": self.visibility, **b.layout} for i, b in enumerate(self.bindings)]
            self._layout = device.wgpu.create_bind_group_layout(entries=entries)
        return self._layout

    def group(self, device: Any, resources: dict[str, Any]) -> Any:
        """The wgpu bind group for these resources (buffers, textures, texture views, samplers), made once.

        Raises TypeError when a resource is missing or unknown.
        """
        if resources.keys() != {b.name for b in self.bindings}:
            raise TypeError(f"bindings are {[b.name for b in self.bindings]}, got {list(resources)}")
        ordered = [resources[b.name] for b in self.bindings]
        key = tuple(map(id, ordered))
        kept = self._groups.get(key)
        # An id may have passed to a new object: the weak references tell.
        if kept and all(ref() is resource for ref, resource in zip(kept[0], ordered, strict=True)):
            return kept[1]
        if len(self._groups) >= _KEPT_GROUPS:
            self._groups.clear()
        pairs = enumerate(zip(self.bindings, ordered, strict=True))
        entries = [{"binding": i, "resource": _as_entry(binding, r)} for i, (binding, r) in pairs]
        group = device.wgpu.create_bind_group(layout=self.layout(device), entries=entries)
        self._groups[key] = ([weakref.ref(r) for r in ordered], group)
        return group


def _as_entry(binding: Binding, resource: Any) -> Any:
    if isinstance(resource, wgpu.GPUBuffer):
        return {"buffer": resource, "offset": 0, "size": binding.window or resource.size}
    if not isinstance(resource, wgpu.GPUTexture):
        return resource
    # An array of one layer would be viewed as a plain texture by default.
    kind = binding.layout.get("texture") or binding.layout["storage_texture"]
    return resource.create_view(dimension=kind["view_dimension"])
