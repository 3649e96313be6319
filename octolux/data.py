"""Where the data that is not part of the package lies: scenes, ground truth, papers' tables."""

from __future__ import annotations

import os
from pathlib import Path


def data_folder() -> Path:
    """The folder named by the environment variable OCTOLUX_DATA, or `shared` beside the checkout.

    The folder need not exist: whoever needs it looks, and says so (tests skip).
    """
    named = os.environ.get("OCTOLUX_DATA")
    return Path(named) if named else Path(__file__).resolve().parents[2] / "shared"
