"""The published cases nearest to a case, and the errors of its model there."""
