"""Commands that take an arm out of Python."""
