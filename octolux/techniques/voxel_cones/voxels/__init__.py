"""From triangles to an octree and what its voxels hold of surfaces, for each part of a scene (VCT 5.2)."""
