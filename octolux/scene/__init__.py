"""Scenes: plain data that any loader fills and any renderer reads. Imports nothing of the GPU."""
