"""Targets, solutions and their checks, as ``urdf-ik ik`` reads and writes them."""
