"""Compiled numerics: arrays in, arrays out, no objects."""
