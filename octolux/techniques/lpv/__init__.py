"""What all light propagation volumes share: cells, injection, propagation, lookup."""
