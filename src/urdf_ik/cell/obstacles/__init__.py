"""The spatial index of a world's obstacles, and its tree of boxes."""
