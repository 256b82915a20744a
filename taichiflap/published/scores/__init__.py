"""Comparison of every model with published data and exact solutions."""
