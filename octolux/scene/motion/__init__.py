"""Keyframes, and what they move: lights, cameras, instances, nodes, and the meshes that these deform."""
