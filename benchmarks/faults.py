"""What is done to files of scenes to damage them: bytes, text, and the headers of pictures.

Each fault gets dice and a file's content, and returns it damaged.
"""

from __future__ import annotations

import io
import random
import re
import struct
import zlib
from collections.abc import Callable

from PIL import Image as Pillow

INTEGERS = (-1, 0, 1, 2, 3, 255, 256, 8191, 16384, 65535, 65536, 2**24, 2**31 - 1, 2**31, 2**32 - 1, 2**53, 2**63)
_FLOATS = (float("nan"), float("inf"), -float("inf"), 1e38, -1e30, 1e-45, 3e9)
_NUMBER = re.compile(rb"(?<![\w.])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[^\s,;]+")
_WRITTEN = (b"-1", b"0", b"1e400", b"nan", b"inf", b"-inf", b"99999999999", b"2147483648", b"4294967295", b"1e38",
            b"-2147483649", b"1e-40", b"", b"x", b"0x10", b"1_0", b"1.5", b"\xff\xfe", b"9" * 5000)  # fmt: skip
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
        number = dice.choice((*INTEGERS, old * 1000, old + 1, old * 2))
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
