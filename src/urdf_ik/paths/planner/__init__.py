"""The planner: a graph of all branches and turns, the search through it, proofs, and the reasons for a stop."""
