"""References of the light propagation volume: transfer constants, injection, propagation, lookup."""
