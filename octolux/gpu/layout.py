"""One declaration for a struct on both sides: NumPy dtype here, WGSL text there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

# WGSL type -> (NumPy base, shape, alignment, size) in bytes; WGSL specification, section 14.4.1 "Alignment and Size".
_TYPES: dict[str, tuple[str, tuple[int, ...], int, int]] = {
    "f32": ("f4", (), 4, 4),
    "i32": ("i4", (), 4, 4),
    "u32": ("u4", (), 4, 4),
    "vec2f": ("f4", (2,), 8, 8),
    "vec2u": ("u4", (2,), 8, 8),
    "vec3f": ("f4", (3,), 16, 12),
    "vec3u": ("u4", (3,), 16, 12),
    "vec3i": ("i4", (3,), 16, 12),
    "vec4f": ("f4", (4,), 16, 16),
    "vec4u": ("u4", (4,), 16, 16),
    "mat4x4f": ("f4", (4, 4), 16, 64),
}


def _from_word(kind: str, offset: int) -> str:
    """WGSL text that takes a member at byte `offset` out of the words w0, w1, ... (vec4u)."""
    width = _TYPES[kind][3] // 4
    if width > 4:
        raise ValueError(f"a {kind} does not lie in one 16-byte word")
    first = offset % 16 // 4
    return f"bitcast<{kind}>(w{offset // 16}.{'xyzw'[first : first + width]})"


def _as_bits(kind: str, value: str) -> str:
    """WGSL text of a member's bits, as u32 or a vector of them."""
    width = _TYPES[kind][3] // 4
    return f"bitcast<{'u32' if width == 1 else f'vec{width}u'}>({value})"


def _round_up(value: int, step: int) -> int:
    return -(-value // step) * step


@dataclass(frozen=True)
class Struct:
    """A WGSL struct: `Struct("Light", position="vec3f", layer="u32")`, laid out by WGSL's rules.

    Matrices are stored by column, as WGSL wants them: assign the transpose of a NumPy matrix (`matrix.T`).
    """

    name: str
    fields: tuple[tuple[str, str], ...]

    def __init__(self, struct_name: str, **fields: str):
        unknown = [f"{k}: {t}" for k, t in fields.items() if t not in _TYPES]
        if unknown or not fields:
            problem = ", ".join(unknown) or "no fields"
            raise ValueError(f"struct {struct_name}: {problem}; types are {', '.join(_TYPES)}")
        object.__setattr__(self, "name", struct_name)
        object.__setattr__(self, "fields", tuple(fields.items()))

    @cached_property
    def dtype(self) -> np.dtype:
        """NumPy dtype with the offsets and the padded size that WGSL gives the struct."""
        offsets, formats, end, alignment = [], [], 0, 4
        for _, kind in self.fields:
            base, shape, align, size = _TYPES[kind]
            end = _round_up(end, align)
            offsets.append(end)
            formats.append((base, shape))
            end, alignment = end + size, max(alignment, align)
        names = [name for name, _ in self.fields]
        size = _round_up(end, alignment)
        return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": size})

    @property
    def wgsl(self) -> str:
        """The declaration as WGSL text, on one line so that it does not shift the lines of its file."""
        return f"struct {self.name} {{ {', '.join(f'{n}: {t}' for n, t in self.fields)} }}"

    @property
    def words(self) -> int:
        """16-byte words of an element. Raises ValueError when the struct does not fill them."""
        if self.size % 16:
            raise ValueError(f"struct {self.name} has {self.size} bytes, not a multiple of 16")
        return self.size // 16

    def wgsl_loader(self, name: str, word: Callable[[int], str] | None = None) -> str:
        """A WGSL function `load_NAME(index) -> STRUCT`, on one line.

        It reads 16 bytes at a time, where a load of the struct would read member by member: on a software adapter each
        load costs about the same, whatever its width. word: text of an element's i-th word; otherwise elements lie in
        `NAME: array<vec4u>`. Raises ValueError when the struct does not fill 16-byte words.
        """
        word = word or (lambda i: f"{name}[{self.words}u * index + {i}u]")
        words = "".join(f"let w{i} = {word(i)}; " for i in range(self.words))
        values = ", ".join(_from_word(kind, self._offset(field)) for field, kind in self.fields)
        return f"fn load_{name}(index: u32) -> {self.name} {{ {words}return {self.name}({values}); }}"

    def wgsl_words(self, value: str) -> list[str]:
        """WGSL text of the 16-byte words (vec4u) of `value`. Its members are vectors and numbers without gaps."""
        members: list[list[str]] = [[] for _ in range(self.words)]
        for field, kind in self.fields:
            members[self._offset(field) // 16].append(_as_bits(kind, f"{value}.{field}"))
        return [f"vec4u({', '.join(parts)})" for parts in members]

    def _offset(self, field: str) -> int:
        assert self.dtype.fields is not None
        return self.dtype.fields[field][1]

    @property
    def size(self) -> int:
        return self.dtype.itemsize

    def array(self, count: int) -> np.ndarray:
        """Zeroed structured array of `count` elements."""
        return np.zeros(count, self.dtype)

    def pack(self, **values) -> np.ndarray:
        """One element with every field given. Raises TypeError when one is missing or unknown."""
        if set(values) != {name for name, _ in self.fields}:
            raise TypeError(f"struct {self.name} has the fields {[n for n, _ in self.fields]}, got {sorted(values)}")
        packed = self.array(1)
        for name, value in values.items():
            packed[name][0] = value
        return packed
