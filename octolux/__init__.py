"""octolux: real-time global illumination for Python."""

__version__ = "0.1.0"
