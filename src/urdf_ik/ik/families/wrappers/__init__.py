"""Wrappers around a plan: for the reversed chain, an imperfect arm, an added or a free axis, a given joint."""
