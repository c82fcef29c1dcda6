"""The viewer: a page in the browser with an arm, every solution of a target to drag, and sliders for its joints.

>>> import urdf_ik
>>> from urdf_ik.show.viewer import Viewer
>>> with Viewer(urdf_ik.load("zyyzyz_6r"), port=0) as viewer:
...     print(len(viewer.state.ghosts))
8

With ``plan=`` of ``arm.follow`` it plays the plan along its waypoints, or marks where each branch ends; ``world=``
shows obstacles. In a notebook, a cell that ends with the viewer shows its page.
"""

from urdf_ik.show.viewer.page import Viewer

__all__ = [
    "Viewer",
]
