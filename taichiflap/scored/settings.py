"""The models and edge settings that are scored: what each sets in a case."""

PAPER = (
    "dbet.coefficients=reade_jankauski", "dbet.frame=chord", "dbet.added_mass=strip", "dbet.attached=false",
    "dbet.rotation=0.0", "dbet.friction=none",
)  # fmt: skip
"""The blade elements as Reade & Jankauski (2020) have them."""
SETTINGS = {
    "dbet-paper": ("solver=dbet", *PAPER),
    "dbet": ("solver=dbet",),
    "uvlm": ("solver=uvlm",),
    "uvlm-suction": ("solver=uvlm", "uvlm.suction=true"),
    "uvlm-sheds": ("solver=uvlm", "uvlm.leading_edge=sheds"),
    "navier-stokes": ("solver=navier_stokes",),
}
"""By name, in the order of the columns."""
