"""Display of results, cases and maps in a notebook."""
