"""`python -m taichiflap` is the command `taichiflap`."""

from .cli import main

main()
