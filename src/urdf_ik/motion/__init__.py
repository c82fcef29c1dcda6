"""Motion of an arm: poses followed as they come, and paths planned as a whole."""
