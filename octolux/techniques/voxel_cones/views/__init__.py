"""Debug views of the octree, its fragments and its cones."""
