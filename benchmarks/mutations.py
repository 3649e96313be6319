"""`python -m benchmarks.mutations K FOLDER`: write case K, a valid scene with one to four faults, into a folder.

Case K is the same in every run: all choices come from `random.Random(K)`. Its original is one of `originals`; its
faults are in the main file or in one of those that it names.
"""

from __future__ import annotations

import io
import json
import random
import re
import struct
import sys
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PIL import Image as Pillow

from .originals import ORIGINALS, files_of, glb

MAIN_SHARE = 0.6  # of the faults that are in the main file, where there are others
_MOST_FAULTS = 4
_TEXTS = (".obj", ".mtl", ".toml", ".off", ".stl", ".ply", ".dae", ".fbx", ".ase", ".x", ".x3d", ".ac", ".ppm", ".hdr")
_INTEGERS = (-1, 0, 1, 2, 3, 255, 256, 8191, 16384, 65535, 65536, 2**24, 2**31 - 1, 2**31, 2**32 - 1, 2**53, 2**63)
_FLOATS = (float("nan"), float("inf"), -float("inf"), 1e38, -1e30, 1e-45, 3e9)
_NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[^\s,;]+")
_WRITTEN = (b"-1", b"0", b"1e400", b"nan", b"inf", b"-inf", b"99999999999", b"2147483648", b"4294967295", b"1e38",
            b"-2147483649", b"1e-40", b"", b"x", b"0x10", b"1_0", b"1.5", b"\xff\xfe", b"9" * 5000)  # fmt: skip
_NAMES = ("/dev/zero", "/dev/stdin", ".", "..", "missing.bin", "a" * 5000, "model.gltf", "\0", "\ud800", "a\nerror: b",
          "data:;base64,A", "data:application/octet-stream;base64,AAAA", "http://localhost/a", "%00", "")  # fmt: skip
# JSON that `json` would not write: these stand in quotes until the text is made.
_RAW = ("1e999", "NaN", "-Infinity", "9" * 5000, "[" * 200 + "]" * 200, "[" * 100_000, '{"a":' * 500 + "1" + "}" * 500,
        "1e-320", "-0", "1.0")  # fmt: skip
_QUOTED = re.compile(r'"<raw (\d+)>"')
# Where the headers of pictures hold their width and height; PNG's has a checksum behind it.
_SIZES = {".png": (16, ">II"), ".bmp": (18, "<ii"), ".gif": (6, "<HH"), ".tga": (12, "<HH"), ".dds": (12, "<II"),
          ".webp": (24, "<HH"), ".ktx2": (20, "<II")}  # fmt: skip
_LENGTHS = (0, 1, 2, 23, 25, 1000, 4096, 8192, 8193, 16383, 32767, 65535, 2**20, 2**31 - 1, 2**32 - 1)

Dice = random.Random
Fault = Callable[[Dice, bytes], bytes]


# Of any file -------------------------------------------------------------------------------------------------------


def flip(dice: Dice, content: bytes) -> bytes:
    """1 to 64 bytes changed, of the whole file or of one stretch of it."""
    data, start = bytearray(content), 0
    if dice.random() < 0.5:
        start = dice.randrange(len(data))
    end = len(data) if dice.random() < 0.5 else min(len(data), start + 200)
    for _ in range(2 ** dice.randrange(7)):
        data[dice.randrange(start, end)] = dice.choice((0, 255, 127, dice.randrange(256)))
    return bytes(data)


def truncate(dice: Dice, content: bytes) -> bytes:
    return content[: dice.randrange(len(content))]


def repeat(dice: Dice, content: bytes) -> bytes:
    """A stretch put in again, once or often."""
    start, place = dice.randrange(len(content)), dice.randrange(len(content))
    piece = content[start : start + dice.choice((1, 4, 30, 500))] * dice.choice((1, 2, 100))
    return content[:place] + piece + content[place:]


def remove(dice: Dice, content: bytes) -> bytes:
    start = dice.randrange(len(content))
    return content[:start] + content[start + dice.choice((1, 4, 12, 300)) :]


def insert(dice: Dice, content: bytes) -> bytes:
    place = dice.randrange(len(content))
    return content[:place] + dice.randbytes(dice.choice((1, 3, 4, 100))) + content[place:]


def exaggerate(dice: Dice, content: bytes, most: int = 2**40) -> bytes:
    """A number of 2, 4 or 8 bytes made extreme: an index, a count, an offset, a length or a coordinate."""
    kind = dice.choice(("<H", "<I", ">I", ">H", "<Q", "<f"))
    size = struct.calcsize(kind)
    if len(content) < size:
        return content
    start = dice.randrange(min(most, len(content) - size + 1))
    start -= start % 2 if dice.random() < 0.8 else 0
    if kind == "<f":
        value = struct.pack(kind, dice.choice(_FLOATS))
    else:
        old = struct.unpack_from(kind, content, start)[0]
        number = dice.choice((*_INTEGERS, old * 1000, old + 1, old * 2))
        value = struct.pack(kind, number % 2 ** (8 * size))
    return content[:start] + value + content[start + size :]


def in_header(dice: Dice, content: bytes) -> bytes:
    return exaggerate(dice, content, 128)


ANY: tuple[Fault, ...] = (flip, flip, truncate, repeat, remove, insert, exaggerate, exaggerate, in_header)


# Of text -----------------------------------------------------------------------------------------------------------


def number_in_text(dice: Dice, content: bytes) -> bytes:
    """A written number replaced, or multiplied by 1000."""
    found = list(_NUMBER.finditer(content))
    if not found:
        return content
    place = dice.choice(found)
    grown = place[0] + b"000" if b"." not in place[0] else place[0] + b"e9"
    return content[: place.start()] + dice.choice((*_WRITTEN, grown, b"-" + place[0])) + content[place.end() :]


def word_in_text(dice: Dice, content: bytes) -> bytes:
    """A word taken out, doubled, replaced by another of the file, made very long, or turned into a device's name."""
    found = list(_WORD.finditer(content))
    if not found:
        return content
    place, other = dice.choice(found), dice.choice(found)
    names = b"/dev/zero", b'"/dev/zero"', b'"."', b'"a\\nb"', b"..", b"\xed\xa0\x80"
    new = dice.choice((b"", place[0] * 2, other[0], place[0] * 3000, b"\0", b"[" * 3000, b"{" * 20, *names))
    return content[: place.start()] + new + content[place.end() :]


def lines_of_text(dice: Dice, content: bytes) -> bytes:
    """A line taken out, moved or repeated, or two joined."""
    lines = content.split(b"\n")
    first, second = dice.randrange(len(lines)), dice.randrange(len(lines))
    change = dice.randrange(4)
    if change == 0:
        del lines[first]
    elif change == 1:
        lines[first], lines[second] = lines[second], lines[first]
    elif change == 2:
        lines[first:first] = [lines[second]] * dice.choice((1, 3, 2000))
    else:
        lines[first : first + 2] = [b" ".join(lines[first : first + 2])]
    return b"\n".join(lines)


def itself(dice: Dice, content: bytes) -> bytes:
    """A model, a library or a map that names a file of the same scene, so that they may go in circles."""
    names = b"model.mtl", b"model.obj", b"scene.toml", b"model.glb", b"/dev/zero", b"."
    name = dice.choice(names)
    forms = b"mtllib %s", b"map_Kd %s", b"bump %s", b'[[model]]\nfile = "%s"', b"map_d -bm 1e40 %s", b'image = "%s"'
    lines = content.split(b"\n")
    lines.insert(dice.randrange(len(lines) + 1), dice.choice(forms) % name)
    return b"\n".join(lines)


TEXT: tuple[Fault, ...] = (number_in_text, number_in_text, number_in_text, word_in_text, lines_of_text, itself)


# Of pictures -------------------------------------------------------------------------------------------------------


def size_of_picture(suffix: str) -> Fault:
    """The size in a picture's header replaced, the checksum behind it kept right."""

    def change(dice: Dice, content: bytes) -> bytes:
        start, kind = _SIZES[suffix]
        if len(content) < start + struct.calcsize(kind) + 9:
            return content
        numbers = list(struct.unpack_from(kind, content, start))
        for index in dice.choice(((0,), (1,), (0, 1))):
            numbers[index] = dice.choice(_LENGTHS) % 2 ** (15 if kind[1] == "H" else 31)
        made = content[:start] + struct.pack(kind, *numbers) + content[start + struct.calcsize(kind) :]
        if suffix == ".png":
            made = made[:29] + struct.pack(">I", zlib.crc32(made[12:29])) + made[33:]
        return made

    return change


def large_png(dice: Dice, content: bytes) -> bytes:
    """A whole picture of many pixels in few bytes, the largest just small enough to be read."""
    stream = io.BytesIO()
    size = dice.choice(((8192, 8192), (8192, 8193), (20_000, 3000), (60_000, 1), (1, 60_000), (3000, 2000)))
    mode, color = dice.choice((("1", 1), ("L", 90), ("P", 3)))
    Pillow.new(mode, size, color).save(stream, "PNG", compress_level=1)
    return stream.getvalue()


def size_of_jpeg(dice: Dice, content: bytes) -> bytes:
    """Height and width in the first frame header (ITU-T T.81, B.2.2)."""
    start = next((p for p in (content.find(bytes((0xFF, 0xC0 + n))) for n in range(3)) if p >= 0), -1)
    if start < 0 or start + 9 > len(content):
        return content
    numbers = (dice.choice(_LENGTHS) % 65536, dice.choice(_LENGTHS) % 65536)
    return content[: start + 5] + struct.pack(">HH", *numbers) + content[start + 9 :]


def window_of_exr(dice: Dice, content: bytes) -> bytes:
    """The corners of the data window, which is the size, or of the display window."""
    name = dice.choice((b"dataWindow\0box2i\0", b"displayWindow\0box2i\0"))
    start = content.find(name) + len(name) + 4
    if start < len(name) + 4 or start + 16 > len(content):
        return content
    corners = [dice.choice((0, 23, -1, 2**31 - 1, -(2**31), 70_000, 9000)) for _ in range(4)]
    return content[:start] + struct.pack("<4i", *corners) + content[start + 16 :]


def size_of_hdr(dice: Dice, content: bytes) -> bytes:
    numbers = dice.choice(_LENGTHS), dice.choice(_LENGTHS)
    return re.sub(rb"-Y \d+ \+X \d+", b"-Y %d +X %d" % numbers, content, count=1)


PICTURES: dict[str, Fault] = {suffix: size_of_picture(suffix) for suffix in _SIZES}
PICTURES |= {".jpg": size_of_jpeg, ".exr": window_of_exr, ".hdr": size_of_hdr}


# Of glTF's JSON ----------------------------------------------------------------------------------------------------


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
    choices = None, True, [], {}, [[]], [None] * 3, "x", 1.5, 1e30, -1e-30, raw, raw, *_INTEGERS[:3]
    owner[key] = dice.choice(choices)


def exaggerate_value(dice: Dice, root: Any) -> None:
    """A number, which most often is an index, a count, an offset or a length."""
    for _ in range(50):
        owner, key = _place(dice, root)
        old = owner.get(key) if isinstance(owner, dict) else owner[key]
        if isinstance(old, int | float) and not isinstance(old, bool):
            owner[key] = dice.choice((*_INTEGERS, old * 1000, old + 1, old - 1, -old, old * 2, old * 1e30))
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


# Cases -------------------------------------------------------------------------------------------------------------


def faults_of(suffix: str) -> tuple[Fault, ...]:
    """What may be done to a file of this kind; what stands often is done often."""
    if suffix == ".gltf":
        return (in_json,) * 8 + (flip, truncate, number_in_text)
    if suffix == ".glb":
        return (in_glb,)
    own = (PICTURES[suffix],) * 5 if suffix in PICTURES else ()
    own += (large_png,) if suffix == ".png" else ()
    return own + (TEXT * 2 if suffix in _TEXTS else ()) + ANY


def original_of(case: int, with_data: bool = True) -> int:
    """Which of ORIGINALS a case damages. with_data: whether those that need the data folder are among them."""
    shares = [o.share if with_data or not o.needs_data else 0 for o in ORIGINALS]
    return Dice(case).choices(range(len(shares)), shares)[0]


def mutated(case: int, with_data: bool = True) -> dict[str, bytes]:
    """The files of a case by name. Raises NeedsData when its original is not there."""
    number = original_of(case, with_data)
    files, dice = dict(files_of(number)), Dice(f"{case} faults")
    main = ORIGINALS[number].main
    others = [name for name in files if name != main]
    name = main if not others or dice.random() < MAIN_SHARE else dice.choice(others)
    for _ in range(dice.choice((1, 1, 1, 2, _MOST_FAULTS))):
        if files[name]:
            files[name] = dice.choice(faults_of(Path(name).suffix.lower()))(dice, files[name])
    return files


def write_case(case: int, folder: Path, with_data: bool = True) -> Path:
    """Write the files of a case into a folder; returns the main one. Raises NeedsData."""
    for name, content in mutated(case, with_data).items():
        (folder / name).write_bytes(content)
    return folder / ORIGINALS[original_of(case, with_data)].main


if __name__ == "__main__":
    target = Path(sys.argv[2])
    target.mkdir(parents=True, exist_ok=True)
    print(write_case(int(sys.argv[1]), target))
