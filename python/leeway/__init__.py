"""Plans motions of robots and proves how much room they leave.

    >>> import leeway
    >>> robot = leeway.Robot("arm.urdf", "arm.srdf", group="arm")
    >>> world = leeway.World()
    >>> world.add_box("table", size=(1, 1, 0.05), position=(0.6, 0, 0.2))
    >>> result = leeway.plan(robot, world, "ready", goal, margin=0.01)
    >>> result.path, result.certificate.lower

Metres, radians, seconds; z up; quaternions x y z w. Arrays are float64, the joints in the last axis. Tutorials: docs/python.md.
"""

from leeway import _leeway
from leeway._leeway import *  # noqa: F403
from leeway._leeway import __version__

__all__ = sorted(name for name in vars(_leeway) if not name.startswith("_"))
