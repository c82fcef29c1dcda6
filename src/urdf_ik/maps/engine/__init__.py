"""The engine for long runs: chunks, computed in this process or on a cluster, each saved to disk when finished.

A store is a folder that outlives the run which fills it. A run that was killed at any moment continues where it
stopped, and ends with the same bytes. Maps, data sets, placements and surveys use it.

>>> from urdf_ik.maps.engine import Folder, run
>>> with Folder("numbers", {"what": "squares"}, 3) as store:
...     run(lambda k: {str(k): str(k * k).encode()}, store)
3
"""

from __future__ import annotations

from urdf_ik.maps.engine.arm_jobs import versions
from urdf_ik.maps.engine.dask_workers import connect
from urdf_ik.maps.engine.runner import Interrupted, run
from urdf_ik.maps.engine.store_folder import Folder

__all__ = ["Folder", "Interrupted", "connect", "run", "versions"]
