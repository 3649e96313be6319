"""Which techniques, with which settings: `NAME[:PRESET][,KEY=VALUE...]`, and files as references."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass
from pathlib import Path

from ..scene.errors import OctoluxError
from ..techniques import TECHNIQUES, technique_class
from ..techniques.settings import Settings

_CHOICE = re.compile(r"(?P<name>[^:,=]*)(?::(?P<preset>[^:,=]*))?(?P<settings>(?:,[^,=]+=[^,]*)*)")
_FILE = re.compile(r"(?P<path>.*\.(?:exr|npz))(?::(?P<paths>\w+))?", re.IGNORECASE)

BASELINES = ("none", "constant")
"""Techniques that are compared only when asked for: every report has `black` and a fitted `constant`."""


@dataclass(frozen=True)
class Choice:
    """A technique and its settings. label: what the user called it."""

    technique: str
    settings: Settings
    label: str
    preset: str = "default"

    @property
    def seeded(self) -> bool:
        """Whether it draws samples at random: its settings have `seed` and `samples`."""
        return {"seed", "samples"} <= {field.name for field in dataclasses.fields(self.settings)}


def choice(text: str, as_reference: bool = False) -> Choice:
    """`uniform-lpv`, `uniform-lpv:paper`, `uniform-lpv:paper,n=64`. Raises SettingsError that names the nearest.

    as_reference: without a preset take the one named `reference`, where there is one: it shows what other techniques
    would, if they were right.
    """
    found = _CHOICE.fullmatch(text.strip())
    if not found:
        raise OctoluxError(f"A technique is NAME:PRESET,KEY=VALUE, such as uniform-lpv:paper,n=64, not '{text}'.")
    pairs = (pair.partition("=") for pair in found["settings"].split(",")[1:])
    overrides = {key.strip(): value.strip() for key, _, value in pairs}
    settings_class = technique_class(found["name"].strip()).settings_class
    usual = "reference" if as_reference and "reference" in settings_class.PRESETS else "default"
    preset = (found["preset"] or usual).strip()
    settings = settings_class.from_strings(preset, overrides)
    return Choice(found["name"].strip(), settings, text.strip(), preset)


def choices(texts: list[str], reference: str = "") -> list[Choice]:
    """The techniques of the texts, each once; without any, all but the baselines, those that draw samples and the
    reference. Raises OctoluxError for none, an unknown one, or one given twice."""
    if texts:
        found = [choice(text) for text in texts]
        labels = [c.label for c in found]
        if "constant" in labels:
            raise OctoluxError("Every report has a fitted 'constant'. Give yours settings: constant,red=2.")
        twice = next((label for label in labels if labels.count(label) > 1), None)
        if twice:
            raise OctoluxError(f"--technique {twice} is given twice. Give it once.")
        return found
    known = [choice(name) for name in TECHNIQUES if name not in (*BASELINES, reference)]
    return [c for c in known if not c.seeded]


def reference_file(text: str | Path) -> tuple[Path, str] | None:
    """Path and light paths (`first_bounce`, or empty) of a reference that is a file; None for a technique."""
    found = _FILE.fullmatch(str(text))
    return (Path(found["path"]), found["paths"] or "") if found else None
