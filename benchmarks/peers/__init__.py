"""What our speed is held against: each peer computes the same thing, or says how it differs."""
