"""How each model compares with published data and exact solutions, quantity by quantity."""
