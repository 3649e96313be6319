"""What is done to glTF files: to the members of their JSON, and to the chunks of a GLB."""

from __future__ import annotations

import json
import re
from typing import Any

from .faults import ANY, INTEGERS, Dice, flip
from .written_gltf import glb

_NAMES = ("/dev/zero", "/dev/stdin", ".", "..", "missing.bin", "a" * 5000, "model.gltf", "\0", "\ud800", "a\nerror: b",
          "data:;base64,A", "data:application/octet-stream;base64,AAAA", "http://localhost/a", "%00", "")  # fmt: skip
# JSON that `json` would not write: these stand in quotes until the text is made.
_RAW = ("1e999", "NaN", "-Infinity", "9" * 5000, "[" * 200 + "]" * 200, "[" * 100_000, '{"a":' * 500 + "1" + "}" * 500,
        "1e-320", "-0", "1.0")  # fmt: skip
_QUOTED = re.compile(r'"<raw (\d+)>"')


def _paths(value: Any, path: tuple = ()) -> list[tuple]:
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(found for key, below in inside for found in _paths(below, (*path, key)))]


def _place(dice: Dice, root: Any) -> tuple[Any, Any]:
    """A random member: what holds it, and its key. Each of the file's lists is as likely as the others."""
    top = dice.choice([key for key in root if root[key] or root[key] == 0] or [None])
    path = dice.choice(_paths(root.get(top), (top,)))
    owner = root
    for key in path[:-1]:
        owner = owner[key]
    return owner, path[-1]


def replace_value(dice: Dice, root: Any) -> None:
    """By a value of another type, of no use, or of no end."""
    owner, key = _place(dice, root)
    raw = f"<raw {dice.randrange(len(_RAW))}>"
    choices = None, True, [], {}, [[]], [None] * 3, "x", 1.5, 1e30, -1e-30, raw, raw, *INTEGERS[:3]
    owner[key] = dice.choice(choices)


def exaggerate_value(dice: Dice, root: Any) -> None:
    """A number, which most often is an index, a count, an offset or a length."""
    for _ in range(50):
        owner, key = _place(dice, root)
        old = owner.get(key) if isinstance(owner, dict) else owner[key]
        if isinstance(old, int | float) and not isinstance(old, bool):
            owner[key] = dice.choice((*INTEGERS, old * 1000, old + 1, old - 1, -old, old * 2, old * 1e30))
            return


def rename_text(dice: Dice, root: Any) -> None:
    """A text: a file's name, a type, a mode, a path of an animation."""
    for _ in range(50):
        owner, key = _place(dice, root)
        old = owner.get(key) if isinstance(owner, dict) else owner[key]
        if isinstance(old, str):
            kinds = "SCALAR", "VEC2", "VEC3", "VEC4", "MAT4", "TRIANGLES", "weights", "scale", "STEP", "CUBICSPLINE"
            owner[key] = dice.choice((*_NAMES, *kinds))
            return


def remove_member(dice: Dice, root: Any) -> None:
    owner, key = _place(dice, root)
    if isinstance(owner, list) or key in owner:
        del owner[key]


def rename_key(dice: Dice, root: Any) -> None:
    owner, key = _place(dice, root)
    if isinstance(owner, dict) and key in owner:
        owner[str(key) + dice.choice(("x", "_1", "\n"))] = owner.pop(key)


def move_member(dice: Dice, root: Any) -> None:
    """One member put in the place of another, or a list made longer with its own."""
    (first, one), (second, other) = _place(dice, root), _place(dice, root)
    if isinstance(first, list) and dice.random() < 0.5:
        first += [first[one]] * dice.choice((1, 50))
    elif isinstance(second, list) or other in second:
        found = first.get(one) if isinstance(first, dict) else first[one]
        second[other] = json.loads(json.dumps(found))  # a copy: nothing may hold itself


MEMBERS = (replace_value, exaggerate_value, exaggerate_value, rename_text, remove_member, rename_key, move_member)


def in_json(dice: Dice, content: bytes) -> bytes:
    """One fault in the text's members; in its bytes where it is no JSON any more."""
    try:
        root = json.loads(content)
        if not isinstance(root, dict) or not root:
            raise ValueError
    except (ValueError, RecursionError):
        return flip(dice, content)
    dice.choice(MEMBERS)(dice, root)
    text = json.dumps(root, indent=1 if content.count(b"\n") else None)
    return _QUOTED.sub(lambda found: _RAW[int(found[1])], text).encode()


def in_glb(dice: Dice, content: bytes) -> bytes:
    """One fault in the JSON, in the binary chunk, or anywhere."""
    length = int.from_bytes(content[12:16], "little")
    chosen = dice.random()
    if content[:4] != b"glTF" or chosen < 0.15 or len(content) < 28 + length:
        return dice.choice(ANY)(dice, content)
    text, binary = content[20 : 20 + length], content[28 + length :]
    if chosen < 0.65:
        return glb(in_json(dice, text), binary)
    return glb(text, dice.choice(ANY)(dice, binary)) if binary else content
