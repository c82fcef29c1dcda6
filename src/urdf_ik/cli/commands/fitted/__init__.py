"""Commands that fit an arm to measurements."""
