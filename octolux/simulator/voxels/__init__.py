"""Voxels of a scene's surfaces in a dense grid, and their pyramids: what the octree of voxel cone tracing holds."""
