"""The octree light propagation volume."""
