"""Cones through bricks, and what pixels gather through them (VCT 5.6)."""
