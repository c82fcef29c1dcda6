"""Labelled samples of an arm for learning: joint vectors, poses, every solution, in memory or on the disk.

>>> import urdf_ik
>>> found = urdf_ik.maps.dataset(urdf_ik.load("zyyzyz_6r"), 1000, seed=7)
>>> found.q.shape, found.solutions.shape, bool((found.branch >= 0).all())
((1000, 6), (1000, 8, 6), True)
"""

from __future__ import annotations

from urdf_ik.maps.datasets.creation import dataset
from urdf_ik.maps.datasets.samples import CHUNK, Samples
from urdf_ik.maps.datasets.stored_samples import StoredSamples

__all__ = ["CHUNK", "Samples", "StoredSamples", "dataset"]
