"""How results, cases and maps look in a notebook."""
