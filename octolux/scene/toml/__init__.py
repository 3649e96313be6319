"""Scenes written by hand in TOML; docs/scenes.md lists their keys."""
