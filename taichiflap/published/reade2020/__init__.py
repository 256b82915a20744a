"""The founding paper redone: Reade & Jankauski (2020), statement by statement."""
