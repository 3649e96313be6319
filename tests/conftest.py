"""Fixtures that all tests share."""

from __future__ import annotations

import pytest

from octolux.gpu.device import Device


@pytest.fixture(scope="session")
def device() -> Device:
    """One device for the whole run; a machine without any adapter fails here, with the remedy in the message."""
    return Device()
