"""Content of a picture of a frame, as plain arrays: shared by figures, exports and the viewer."""
