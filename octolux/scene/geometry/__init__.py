"""Normals, tangents and extents of triangles, in NumPy."""
