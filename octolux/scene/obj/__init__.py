"""Wavefront OBJ with MTL."""
