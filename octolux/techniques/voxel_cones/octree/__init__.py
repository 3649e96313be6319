"""Nodes of the sparse octree, its pools, and how shaders read it (VCT 5.2)."""
