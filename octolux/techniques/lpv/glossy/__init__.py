"""Glossy reflections of light in cells: rays marched through nested windows."""
