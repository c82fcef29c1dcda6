"""Shared by families: their records, the arm as written, ideal arms, the elimination's matrices, explanations."""
