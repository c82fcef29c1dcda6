"""What the commands do whose work is in chunks: maps, base positions, samples, and the checks of many arms."""
