"""Studies: sweeps, convergence, optimisation and strips, run through the common march."""
