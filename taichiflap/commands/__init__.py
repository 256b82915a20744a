"""Commands of the command line, a module for each family. `taichiflap.cli` puts them together."""
