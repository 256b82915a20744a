"""How to cite taichiflap and the paper it is based on. A test keeps `CITATION.cff` consistent."""

from .._version import __version__

PAPER = "10.1115/DETC2020-22638"

BIBTEX = f"""@software{{taichiflap,
  title   = {{taichiflap: fast, trustworthy models of flexible flapping wings}},
  author  = {{{{The taichiflap authors}}}},
  version = {{{__version__}}},
  year    = {{2026}},
  license = {{MIT}}
}}

@inproceedings{{reade2020deformable,
  title     = {{Deformable Blade Element and Unsteady Vortex Lattice Fluid-Structure Interaction Modeling of a 2D
               Flapping Wing}},
  author    = {{Reade, Joseph and Jankauski, Mark A.}},
  booktitle = {{Proceedings of the ASME 2020 International Design Engineering Technical Conferences and Computers and
               Information in Engineering Conference}},
  year      = {{2020}},
  note      = {{DETC2020-22638}},
  doi       = {{{PAPER}}}
}}"""
