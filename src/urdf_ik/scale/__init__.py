"""Long work in chunks that are kept on the disk as they are made, in this process or on a cluster.

A store is a folder that outlives the run which fills it: killed at any moment, the same run goes on where it stopped,
and ends with the same bytes. What maps, data sets and placements have in common stands here.

>>> from urdf_ik.scale import Folder, run
>>> with Folder("numbers", {"what": "squares"}, 3) as store:
...     run(lambda k: {str(k): str(k * k).encode()}, store)
3
"""

from __future__ import annotations

from urdf_ik.scale.cluster import connect, versions
from urdf_ik.scale.folder import Folder
from urdf_ik.scale.running import Interrupted, run

__all__ = ["Folder", "Interrupted", "connect", "run", "versions"]
