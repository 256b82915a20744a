"""Speed, as ratios within one run to what the hardware can do and to what a user would pick instead: `make bench`."""
