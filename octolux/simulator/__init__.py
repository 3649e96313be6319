"""Float64 NumPy references of every kernel: the executable specification of octolux. Imports nothing of the GPU.

The GPU kernels are tested against these functions and take their constants from them.
"""
