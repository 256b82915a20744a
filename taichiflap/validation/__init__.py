"""The models compared with exact theory."""
