"""Light into voxels: injected, and reflected there (VCT 5.5, 7.2)."""
