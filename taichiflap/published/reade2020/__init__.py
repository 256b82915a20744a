"""Reproduction of Reade & Jankauski (2020), statement by statement."""
