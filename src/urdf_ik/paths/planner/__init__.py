"""How a path is followed: a graph of all branches and turns, the search through it, proofs and what stops a path."""
