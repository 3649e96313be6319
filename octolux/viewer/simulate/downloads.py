"""Files for the user: made here, saved by the browser."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from functools import partial
from itertools import count

from bokeh.layouts import column, row
from bokeh.models import CustomJS, Div, UIElement

from octolux.simulator.laboratory import results
from octolux.simulator.laboratory.pictures import error_figure, slice_figure

from .controls import Do, button, heading
from .laboratory import Laboratory

_SAVE = """
const file = JSON.parse(cb_obj.text)
const bytes = Uint8Array.from(atob(file.data), letter => letter.charCodeAt(0))
const link = document.createElement("a")
link.href = URL.createObjectURL(new Blob([bytes]))
link.download = file.name
link.click()
setTimeout(() => URL.revokeObjectURL(link.href), 60000)
"""


def slices_png(laboratory: Laboratory) -> bytes:
    """The three grids as they are looked at."""
    view = laboratory.view
    return results.png(
        slice_figure(laboratory.simulation, view.axis, view.index, view.level, view.scale, view.zoom)
    )  # fmt: skip


FILES: dict[str, Callable[[Laboratory], bytes]] = {
    "slices.png": slices_png,
    "errors.png": lambda laboratory: results.png(error_figure(laboratory.simulation.state.measures)),
    "errors.csv": lambda laboratory: results.errors_csv(laboratory.simulation.state.measures),
    "state.npz": lambda laboratory: results.state_npz(laboratory.simulation.state),
}
"""What can be saved, by name."""


def download_controls(laboratory: Laboratory, do: Do) -> UIElement:
    """A button for each of `FILES`."""
    carrier = Div(visible=False, name="carrier")
    carrier.js_on_change("text", CustomJS(code=_SAVE))
    numbers = count()  # the same file twice is two changes

    def save(name: str) -> None:
        def made() -> None:
            data = base64.b64encode(FILES[name](laboratory)).decode()
            carrier.text = json.dumps({"name": name, "data": data, "number": next(numbers)})

        laboratory.act(f"saved {name}", made)

    buttons = [button(name, name, partial(save, name), do, 70) for name in FILES]
    return column(heading("Save"), row(*buttons), carrier)
