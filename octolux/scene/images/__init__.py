"""Pictures: textures of materials and surroundings, decoded when needed, and the cache of what was made of them."""
