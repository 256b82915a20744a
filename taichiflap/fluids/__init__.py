"""Fluid models. Each is one module behind the same interface, which `taichiflap.march` describes."""
