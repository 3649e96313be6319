"""Light in space, as a technique's light cache knows it: what fog asks for between surfaces."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..gpu.bindings import Binding
from ..gpu.layout import Struct


@dataclass(frozen=True, eq=False)
class VolumeLight:
    """A technique sets `frame.volume_light` to one while it updates, and fog shows that light as well.

    file: of the package, which defines

    - `fn volume_fluence(position: vec3f) -> vec3f`: indirect radiance integrated over all directions, lx or W/m^2,
      without what lamps, emitters and the sky bring directly, which shadow maps tell; 0 outside of the volume;
    - `fn volume_step(position: vec3f) -> f32`: edge of a cell there, metres, above 0.

    bindings, structs, resources: what the file reads, under names of its own.  values: what its template wants to know.
    """

    file: str
    bindings: tuple[Binding, ...] = ()
    structs: tuple[Struct, ...] = ()
    resources: dict[str, Any] = field(default_factory=dict)
    values: dict[str, Any] = field(default_factory=dict)

    @property
    def key(self) -> tuple:
        """The same for two whose shaders are the same."""
        return self.file, self.bindings, repr(sorted(self.values.items()))
