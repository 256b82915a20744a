"""The interface to Taichi, and arrays and linear solvers for kernels."""
