"""Radiance pictures, .hdr and .pic (G. Ward, "Real Pixels", Graphics Gems II, 1991; Radiance's file format reference).

Own code, for the libraries that read them are tens of megabytes (OpenImageIO, OpenCV) or fetch plug-ins (imageio).
"""

from __future__ import annotations

import re

import numpy as np

_SIZE = re.compile(rb"([-+])Y (\d{1,9}) ([-+])X (\d{1,9})\Z")
# CIE XYZ to linear Rec. 709 (IEC 61966-2-1), for pictures in XYZE.
_FROM_XYZ = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
_LONGEST_RUN = 127


class HdrFault(ValueError):
    """What is wrong with a file, as a sentence without a full stop."""


def read_hdr(data: bytes, most_pixels: int) -> np.ndarray:
    """float32 (height, width, 3), linear Rec. 709, row 0 at the top, in the file's unit (W/(sr m^2) by its definition).

    Raises HdrFault: no such file, more than `most_pixels` (before anything is decoded), cut off, or of the run-length
    coding of before 1991.
    """
    lines, start = _header(data)
    match = _SIZE.match(lines[-1])
    if not match:
        raise HdrFault("its size is not given as '-Y height +X width'")
    height, width = int(match[2]), int(match[4])
    if not 0 < height * width <= most_pixels:
        raise HdrFault(f"has {width} x {height} pixels, of at most {most_pixels}")
    rows = _rows(memoryview(data)[start:], height, width)
    colors = _colors(rows) / np.float32(_exposure(lines))
    if b"FORMAT=32-bit_rle_xyze" in lines:
        colors = (colors @ _FROM_XYZ.T).astype(np.float32)
    return colors[:: -1 if match[1] == b"+" else 1, :: -1 if match[3] == b"-" else 1]


def _header(data: bytes) -> tuple[list[bytes], int]:
    """The lines up to the one with the size, and where the pixels begin."""
    if not data.startswith(b"#?"):
        raise HdrFault("is no Radiance picture: it does not begin with '#?'")
    blank = data.find(b"\n\n", 0, 1 << 16)
    end = data.find(b"\n", blank + 2, blank + 2 + 64)
    if blank < 0 or end < 0:
        raise HdrFault("its header does not end")
    return [*data[:blank].split(b"\n"), data[blank + 2 : end].strip()], end + 1


def _exposure(lines: list[bytes]) -> float:
    """The product of the EXPOSURE lines, by which the stored values have been multiplied."""
    product = 1.0
    for line in lines:
        if line.startswith(b"EXPOSURE="):
            try:
                product *= float(line.partition(b"=")[2])
            except ValueError as error:
                raise HdrFault(f"'{line.decode(errors='replace')}' is no number") from error
    if not 1e-30 < product < 1e30:
        raise HdrFault(f"its exposure is {product:g}")
    return product


def _rows(data: memoryview, height: int, width: int) -> np.ndarray:
    """uint8 (height, width, 4): red, green, blue, exponent."""
    coded = 8 <= width < 32768 and len(data) >= 4 and tuple(data[:4]) == (2, 2, width >> 8, width & 255)
    if not coded:
        if len(data) < height * width * 4:
            raise HdrFault("is cut off")
        return np.frombuffer(data[: height * width * 4], np.uint8).reshape(height, width, 4)
    least = height * (4 + 4 * 2 * -(-width // _LONGEST_RUN))
    if len(data) < least:  # before memory is taken for what cannot be there
        raise HdrFault("is cut off")
    rows, position, source = np.empty((height, 4, width), np.uint8), 0, bytes(data)
    for row in rows:
        position = _read_row(source, position, width, row)
    return rows.transpose(0, 2, 1)


def _read_row(data: bytes, position: int, width: int, row: np.ndarray) -> int:
    """Decode one row, uint8 (4, width), and return where the next begins. Each channel is a sequence of runs (a byte
    above 128, then what is repeated) and of literals (their count, then they)."""
    if data[position : position + 4] != bytes((2, 2, width >> 8, width & 255)):
        raise HdrFault("a row does not begin as one, or is of the coding of before 1991")
    position += 4
    for channel in range(4):
        values = bytearray()
        while len(values) < width and position + 1 < len(data):
            count = data[position]
            if count > 128:
                values += data[position + 1 : position + 2] * (count - 128)
                position += 2
            else:
                values += data[position + 1 : position + 1 + count]
                position += 1 + max(count, 1)
        if len(values) != width:
            raise HdrFault("is cut off, or its rows are of different lengths")
        row[channel] = np.frombuffer(values, np.uint8)
    return position


def _colors(rows: np.ndarray) -> np.ndarray:
    """float32 (height, width, 3): (mantissa + 0.5) / 256 * 2^(exponent - 128), black where the exponent is 0 (Ward)."""
    exponent = rows[..., 3].astype(np.int32)
    scale = np.where(exponent > 0, np.ldexp(np.float32(1.0), exponent - 136), 0).astype(np.float32)
    return (rows[..., :3].astype(np.float32) + np.float32(0.5)) * scale[..., None]
