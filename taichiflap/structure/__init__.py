"""The elastic section: distributions along the chord and the modes that follow from them."""
