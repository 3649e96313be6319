"""Fixtures that all tests share."""

from __future__ import annotations

import os

import pytest

from octolux.gpu.device import Device

# Tests neither read nor write the user's cache; those of the cache name a folder of their own.
os.environ["OCTOLUX_CACHE"] = "off"


@pytest.fixture(scope="session")
def device() -> Device:
    """One device for the whole run; a machine without any adapter fails here, with the remedy in the message."""
    return Device()
