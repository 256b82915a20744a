"""Studies: many cases through the one march, and what they amount to."""
