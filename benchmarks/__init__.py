"""Benchmarks as ratios to the hardware's limit and to alternative programs, within one run: `make bench`."""
