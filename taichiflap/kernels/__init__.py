"""The doorway to Taichi, and the arrays and eliminations that every kernel uses."""
