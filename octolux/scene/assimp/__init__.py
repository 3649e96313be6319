"""The formats that assimp reads, in a process of its own."""
