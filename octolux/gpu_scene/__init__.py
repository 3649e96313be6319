"""The scene on the device: geometry in clusters, materials, textures by size class. Updated when the scene changes."""
