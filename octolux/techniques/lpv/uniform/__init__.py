"""The uniform light propagation volume."""
