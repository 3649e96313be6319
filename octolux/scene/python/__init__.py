"""Scenes from arrays and from the objects of other libraries."""
