"""The browser viewer of maps."""
