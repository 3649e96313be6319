"""The device layer: adapter, resources, shader modules, passes and the profiler. Knows nothing of light."""
