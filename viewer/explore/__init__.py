"""A case explored by sliders: every change is computed at once, and wing, wake, charts and numbers follow."""
