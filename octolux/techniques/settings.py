"""Settings of techniques: frozen dataclasses whose fields say what they mean, allow and cost."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Callable
from typing import Any, ClassVar, Self

from ..scene.errors import OctoluxError


class SettingsError(OctoluxError):
    """A setting, preset or technique that does not exist, or a value that is not allowed."""


@dataclasses.dataclass(frozen=True)
class Form:
    """Texts that say more than a name. text: what they are, for people.  read: what one says, or ValueError."""

    text: str
    read: Callable[[str], Any]


def setting(default: Any, *, meaning: str, unit: str, allowed: Any, cost: str, source: str) -> Any:
    """A field of a settings class.

    allowed: a tuple of choices, a `range`-like pair [low, high] as a list, or a Form of texts.  cost: what more and
    less of it does.  source: the paper's section it comes from.
    """
    metadata = {"meaning": meaning, "unit": unit, "allowed": allowed, "cost": cost, "source": source}
    return dataclasses.field(default=default, metadata=metadata)


def suggest(word: str, known: Any) -> str:
    """` Did you mean 'x'?` when something near is known, and all that is known otherwise."""
    near = difflib.get_close_matches(word, list(known), n=1, cutoff=0.5)
    return f"Did you mean '{near[0]}'?" if near else f"There are: {', '.join(known)}."


@dataclasses.dataclass(frozen=True)
class Settings:
    """Base of all settings. `PRESETS` are named changes of the defaults; "default" is always there."""

    PRESETS: ClassVar[dict[str, dict[str, Any]]] = {}

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            _check(field, getattr(self, field.name))

    @classmethod
    def from_strings(cls, preset: str = "default", overrides: dict[str, str] | None = None) -> Self:
        """Settings from a preset and texts such as {"n": "64"}. Raises SettingsError that names the nearest."""
        fields = {field.name: field for field in dataclasses.fields(cls)}
        texts = overrides or {}
        return cls.make(preset, **{k: _parse(fields[k], text) if k in fields else text for k, text in texts.items()})

    @classmethod
    def make(cls, preset: str = "default", **values: Any) -> Self:
        """Settings from a preset and values such as n=64. Raises SettingsError that names the nearest."""
        presets = {"default": {}, **cls.PRESETS}
        if preset not in presets:
            raise SettingsError(f"There is no preset '{preset}'. {suggest(preset, presets)}")
        fields = [field.name for field in dataclasses.fields(cls)]
        for name in values:
            if name not in fields:
                raise SettingsError(f"There is no setting '{name}'. {suggest(name, fields or ['(none)'])}")
        return cls(**{**presets[preset], **values})

    def as_dict(self) -> dict[str, Any]:
        return dataclasses.asdict(self)


def allowed_text(allowed: Any, unit: str) -> str:
    """What a setting may be, for people: `one of a, b` or `0 to 256 (steps)`."""
    if isinstance(allowed, Form):
        return allowed.text + (f" ({unit})" if unit else "")
    if isinstance(allowed, tuple):
        return "one of " + ", ".join(map(str, allowed))
    return f"{allowed[0]} to {allowed[1]}" + (f" ({unit})" if unit else "")


def _check(field: dataclasses.Field, value: Any) -> None:
    allowed = field.metadata["allowed"]
    kind = type(field.default)
    good = isinstance(value, kind) or (kind is float and isinstance(value, int) and not isinstance(value, bool))
    if good and isinstance(allowed, Form):
        good = _reads(allowed, value)
    elif good and isinstance(allowed, tuple):
        good = value in allowed
    elif good:
        good = allowed[0] <= value <= allowed[1]
    if not good:
        raise SettingsError(
            f"Setting '{field.name}' is {allowed_text(allowed, field.metadata['unit'])}, not {value!r}."
        )


def _reads(form: Form, text: str) -> bool:
    try:
        form.read(text)
    except ValueError:
        return False
    return True


def _parse(field: dataclasses.Field, text: str) -> Any:
    # bool("false") would be True
    kind: Any = {"true": True, "false": False}.__getitem__ if field.type == "bool" else type(field.default)
    try:
        return kind(text.lower())
    except (ValueError, KeyError):
        allowed = allowed_text(field.metadata["allowed"], field.metadata["unit"])
        raise SettingsError(f"Setting '{field.name}' is {allowed}, not '{text}'.") from None
