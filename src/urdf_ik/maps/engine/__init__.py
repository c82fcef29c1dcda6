"""Long work in chunks that are kept on the disk as they are made, in this process or on a cluster.

A store is a folder that outlives the run which fills it: killed at any moment, the same run goes on where it stopped,
and ends with the same bytes. Maps, data sets, placements and surveys are made this way.

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
