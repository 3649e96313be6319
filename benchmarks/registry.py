"""The registry of figures: each is one small function; a decorator names it and says what must hold of it."""

from __future__ import annotations

import importlib
import math
import traceback
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from octolux.scene.errors import OctoluxError
from octolux.techniques.settings import suggest

# Where figures are; a new file of figures is one more name here. Their order is the table's.
MODULES = (
    "closed_form", "injected_flux", "readings", "kernels", "light_kernels", "determinism", "ground_truth",
    "comparison", "stages", "injection", "propagation", "shadow_faces", "raytracing", "path_tracing", "crytek",
    "loading", "bad_input", "mutated", "live", "sequences", "olpv_kernels", "olpv_table1", "olpv_sparse",
    "olpv_artefacts", "clpv_propagation", "clpv_peeling", "clpv_ao", "clpv_emitted", "clpv_area", "clpv_fog",
    "clpv_glossy",
    "clpv_stability", "clpv_motion", "clpv_table1", "clpv_ratios", "vct_rows", "vct_closed_forms",
    "vct_dense", "vct_motion", "vct_cost", "vct_accuracy", "vct_gathering",
)  # fmt: skip


class NeedsData(Exception):
    """The data folder, or what a figure reads from it, is not there."""


class UnknownFigure(OctoluxError):
    """A name that is neither a figure nor a group."""


@dataclass(frozen=True)
class Bound:
    """What must hold of a value: low <= value <= high. `text` is how the table says it; an aim may be missed."""

    low: float = -math.inf
    high: float = math.inf
    text: str = ""
    aim: bool = False

    def holds(self, value: float) -> bool | None:
        """None where nothing is demanded; a value that is not a number never holds."""
        if self.aim or self == Bound():
            return None
        return self.low <= value <= self.high


@dataclass(frozen=True)
class Row:
    """One line of the table. value: None when there is none, and then `problem` says why."""

    name: str
    group: str
    value: float | None
    unit: str
    bound: str
    holds: bool | None
    problem: str = ""


@dataclass(frozen=True)
class Figure:
    """A registered function. unit and bounds are one for all values it returns, or a mapping from a value's name."""

    name: str
    group: str
    unit: str | Mapping[str, str]
    bounds: Bound | Mapping[str, Bound]
    measure: Callable[[], Any]

    @property
    def summary(self) -> str:
        """First line of the function's docstring."""
        return (self.measure.__doc__ or "").strip().partition("\n")[0]

    def rows(self) -> list[Row]:
        """Measure. A figure that fails is a row that does not hold; one whose data is missing is not counted."""
        try:
            found = self.measure()
        except NeedsData as missing:
            return [Row(self.name, self.group, None, "", "", None, f"needs OCTOLUX_DATA ({missing})")]
        except Exception as error:  # one broken figure must not hide the others
            traceback.print_exc()
            return [Row(self.name, self.group, None, "", "", False, f"{type(error).__name__}: {error}")]
        if not isinstance(found, Mapping):
            return [self._row("", float(found))]
        return [self._row(key, float(value)) for key, value in found.items()]

    def _row(self, key: str, value: float) -> Row:
        bound = self.bounds if isinstance(self.bounds, Bound) else self.bounds.get(key, Bound())
        unit = self.unit if isinstance(self.unit, str) else self.unit.get(key, "")
        name = f"{self.name}.{key}" if key else self.name
        return Row(name, self.group, value, unit, bound.text, bound.holds(value))


FIGURES: dict[str, Figure] = {}


def at_least(low: float) -> Bound:
    return Bound(low=low, text=f">= {low:g}")


def at_most(high: float) -> Bound:
    return Bound(high=high, text=f"<= {high:g}")


def within(middle: float, tolerance: float) -> Bound:
    """middle - tolerance to middle + tolerance."""
    return Bound(middle - tolerance, middle + tolerance, f"{middle:.6g} ± {tolerance:g}")


def aim(text: str) -> Bound:
    """Something worth reaching, printed and not demanded."""
    return Bound(text=f"aim: {text}", aim=True)


def figure(
    name: str, *, group: str, unit: str | Mapping[str, str] = "", bound: Bound | Mapping[str, Bound] = Bound()
) -> Callable[[Callable[[], Any]], Callable[[], Any]]:
    """Register the decorated function, which returns one number or a mapping of names to numbers.

    unit, bound: for all of them, or mappings from those names. Raises ValueError for a name that is taken; figures
    and groups share their names, so that one word selects.
    """
    if name in FIGURES or name in groups() or group in FIGURES or name == group:
        raise ValueError(f"there is a figure or group '{name}' or '{group}' already")

    def register(measure: Callable[[], Any]) -> Callable[[], Any]:
        FIGURES[name] = Figure(name, group, unit, bound, measure)
        return measure

    return register


def groups() -> list[str]:
    return list(dict.fromkeys(f.group for f in FIGURES.values()))


def load_all() -> None:
    """Import every file of figures."""
    for module in MODULES:
        importlib.import_module(f"{__package__}.{module}")


def select(names: Iterable[str]) -> list[Figure]:
    """The figures that `names` (of figures or groups) mean, each once, in the table's order; all when there are none.

    Raises UnknownFigure that names the nearest.
    """
    wanted = list(names)
    known = [*groups(), *FIGURES]
    for name in wanted:
        if name not in known:
            raise UnknownFigure(f"There is no figure or group '{name}'. {suggest(name, known)}")
    return [f for f in FIGURES.values() if not wanted or f.name in wanted or f.group in wanted]
