"""What the issues promise in numbers, measured: `python -m benchmarks` prints every figure beside its bound."""
