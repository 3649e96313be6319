"""`voxel-cones`: cones through a sparse octree of voxels (Drinovsky 2013, after Crassin 2011)."""
