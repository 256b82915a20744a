"""Published data and papers, and how the models compare with them."""
