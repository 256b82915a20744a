"""What the scores say of a case: the published cases nearest to it, and how much its model errs there."""
