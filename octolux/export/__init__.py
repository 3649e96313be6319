"""Scenes for other programs."""
