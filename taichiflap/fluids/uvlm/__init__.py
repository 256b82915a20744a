"""The unsteady vortex lattice: a lumped-vortex lattice on the deformed camber line, with a free wake."""
