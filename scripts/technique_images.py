"""Renders a technique's pictures on the comparison set into docs/images:
`.venv/bin/python scripts/technique_images.py uniform-lpv[:PRESET][,KEY=VALUE...] [VIEW ...]`.

One strip for each view: the final picture, the reference's (all bounces); the indirect light, the reference's (first
bounce, or all where the technique has several); and the signed difference of these two, blue where it is too dark, red
where it is too bright, full colour from the reference's mean on. Views whose data is not there are left alone.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))  # benchmarks is not installed

from benchmarks import comparison  # noqa: E402
from benchmarks.comparison_set import View, reference, views  # noqa: E402
from benchmarks.registry import NeedsData  # noqa: E402
from octolux.compare import colour_maps  # noqa: E402
from octolux.compare.choices import Choice, choice  # noqa: E402
from octolux.compare.metrics import brightness_map  # noqa: E402
from octolux.compare.page_pictures import VIEWS as MAPS  # noqa: E402
from octolux.scene.errors import OctoluxError  # noqa: E402
from octolux.simulator.tonemap import signal  # noqa: E402

FOLDER = ROOT / "docs" / "images"


def strip(view: View, one: Choice) -> np.ndarray:
    """uint8 (height, 5 * width, 3). Indirect light is shown a stop brighter than the scene's exposure has it."""
    several = getattr(one.settings, "bounces", 1) > 1
    known, every = (reference(view, light) for light in ("all_indirect" if several else "first_bounce", "all_indirect"))
    rendering = comparison.picture(view, one)
    indirect, mask = comparison.diffuse_indirect(rendering), known.mask & rendering.mask
    exposure = comparison.studio(view).scene.exposure or 0.0
    finals = (rendering.pictures["direct"] + indirect, every.pictures["direct"] + every.pictures["indirect"])
    shown = [signal(picture, exposure, "neutral") for picture in finals]
    shown += [signal(picture, exposure - 1.0, "neutral") for picture in (indirect, known.pictures["indirect"])]
    pixels = [(255.0 * picture + 0.5).astype(np.uint8) for picture in shown]
    about = MAPS["brightness"]
    difference = colour_maps.levels(
        brightness_map(indirect, known.pictures["indirect"], mask), about["low"], about["high"]
    )
    return np.concatenate([*pixels, colour_maps.palette(about["colours"])[difference]], axis=1)


def main() -> int:
    if len(sys.argv) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    try:
        one, wanted = choice(sys.argv[1]), views(sys.argv[2:])
    except OctoluxError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for view in wanted:
        path = FOLDER / f"{one.technique}-{view.name}.jpg"
        try:
            Image.fromarray(strip(view, one)).save(path, quality=85, optimize=True)
        except NeedsData as missing:
            print(f"{view.name}: left alone, needs OCTOLUX_DATA ({missing})")
            continue
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1000:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
