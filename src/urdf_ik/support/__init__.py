"""Input checks, files, text, tolerances: helpers that every room shares."""
