"""The form for an injector or an occluder: a wall, an element, an area, or a file."""

from __future__ import annotations

from typing import Any

from bokeh.core.property.descriptors import UnsetValueError
from bokeh.layouts import column, row
from bokeh.models import FileInput, NumericInput, RadioButtonGroup, Select, Spinner, TextInput, UIElement

from octolux.simulator.laboratory import Area, Element, Wall
from octolux.simulator.laboratory.injectors import AXES, Injector

from . import entries
from .laboratory import Laboratory

KINDS = {"wall": ("axis", "index"), "element": ("cell",), "area": ("low", "high"), "file": ("file",)}
"""Fields that each kind has besides multiplier and direction; a file has no direction."""

ROLES = ("light", "blocking")


class ShapeForm:
    """`layout` goes on the page; `make` gives what the fields say, for a volume as the laboratory's."""

    def __init__(self, laboratory: Laboratory):
        self._laboratory = laboratory
        n = laboratory.simulation.state.n
        middle = f"{n // 2}, {n // 2}, {n // 2}"
        self._role = RadioButtonGroup(labels=["light", "occluder"], active=0, name="role")
        self._kind = Select(title="shape", options=list(KINDS), value="wall", width=100, name="kind")
        self._multiplier = NumericInput(title="multiplier", value=1.0, mode="float", width=95, name="multiplier")
        self._direction = TextInput(title="direction", value="", placeholder="default", width=95, name="direction")
        self._fields: dict[str, Any] = {
            "axis": Select(title="axis", options=list(AXES), value="x", width=100, name="wall-axis"),
            "index": Spinner(title="index (-1 is the last)", value=0, step=1, width=150, name="wall-index"),
            "cell": TextInput(title="cell x, y, z", value=middle, width=150, name="cell"),
            "low": TextInput(title="from cell x, y, z", value=middle, width=150, name="low"),
            "high": TextInput(title="to cell x, y, z", value=middle, width=150, name="high"),
            "file": FileInput(accept=".npz,.csv", title="NPZ or CSV file", width=310, name="file"),
        }
        self._kind.on_change("value", lambda attr, old, new: self._fit())
        self._fit()

    @property
    def layout(self) -> UIElement:
        return column(
            self._role,
            row(self._kind, self._direction, self._multiplier),
            row(*(self._fields[name] for names in KINDS.values() for name in names)),
        )

    @property
    def role(self) -> str:
        """A name in `ROLES`."""
        return ROLES[self._role.active]

    def make(self) -> Injector:
        """Raises OctoluxError where a field cannot be read or the shape cannot be."""
        kind, f = str(self._kind.value), self._fields
        multiplier = float(1.0 if self._multiplier.value is None else self._multiplier.value)
        if kind == "file":
            n = self._laboratory.simulation.state.n
            name, contents = (_chosen(f["file"], part) for part in ("filename", "value"))
            return entries.uploaded(name, contents, n, self.role, multiplier)
        direction = entries.direction(self._direction.value)
        if kind == "wall":
            return Wall(f["axis"].value, int(f["index"].value or 0), direction, multiplier)
        if kind == "element":
            return Element(entries.cell("the cell", f["cell"].value), direction, multiplier)
        low, high = (entries.cell(f"'{name}'", f[name].value) for name in ("low", "high"))
        return Area(low, high, direction, multiplier)

    def _fit(self) -> None:
        """Only the fields of the chosen kind are seen."""
        for name, field in self._fields.items():
            field.visible = name in KINDS[str(self._kind.value)]
        self._direction.disabled = self._kind.value == "file"


def _chosen(file: FileInput, part: str) -> str:
    """A property of the file that the browser sent; "" before any is chosen."""
    try:
        return str(getattr(file, part))
    except UnsetValueError:
        return ""
