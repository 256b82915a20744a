"""Commands of the command line, one module per group. `taichiflap.cli` assembles them."""
