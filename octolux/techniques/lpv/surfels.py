"""Where a frame's surfels lie: the RSM of each lamp, and the G-buffer."""

from __future__ import annotations

from collections.abc import Iterator

from ...frame.frame import Frame

GBUFFER_SAMPLES = 256  # surfels along the longer side of the picture: as many as an RSM has


def surfel_buffers(frame: Frame, camera: bool) -> Iterator[tuple[bool, dict[str, int]]]:
    """Whether it is the camera's, and `first`, `count`, `width` and `block` of SURFELS, for each buffer that is merged
    by itself (CLPV 3.2). The many coarse maps of the sky and of glowing surfaces are left out: they would cost more
    than they add."""
    for (first, count), width in list(zip(frame.vpl_ranges, frame.vpl_widths, strict=True))[: frame.lights.lamps]:
        yield False, {"first": first, "count": count, "width": width, "block": 1}
    if camera:
        block = max(1, -(-max(frame.pixels) // GBUFFER_SAMPLES))
        width, height = (-(-side // block) for side in frame.pixels)
        yield True, {"first": 0, "count": width * height, "width": width, "block": block}
