"""What nodes hold: bricks of what faces each of six ways and of light, and its filtering (VCT 5.3, 5.4)."""
