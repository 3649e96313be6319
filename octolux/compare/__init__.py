"""Techniques side by side, measured against a reference: `octolux compare`."""

from .comparison import compare
from .report import Entry, Report

__all__ = ["Entry", "Report", "compare"]
