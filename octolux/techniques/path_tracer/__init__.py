"""`path-tracer`: unbiased light transport, the reference of all techniques."""
