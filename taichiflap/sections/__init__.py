"""What each section of a case file may say, one module a section."""
