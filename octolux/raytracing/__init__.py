"""The bounding volume hierarchy on the device, and rays through it."""
