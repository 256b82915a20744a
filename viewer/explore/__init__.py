"""Interactive exploration of a case: every change of a slider is computed at once and shown."""
