"""What a picture of a frame shows, as plain arrays: shared by figures, exports and the viewer."""
