"""Plans motions of robots and proves how much room they leave.

    >>> import leeway
    >>> robot = leeway.Robot("arm.urdf", "arm.srdf", group="arm")
    >>> world = leeway.World()
    >>> world.add_box("table", size=(1, 1, 0.05), position=(0.6, 0, 0.2))
    >>> result = leeway.plan(robot, world, "ready", goal, margin=0.01)
    >>> result.path, result.certificate.lower

Metres, radians, seconds; z up; quaternions x y z w. Arrays are float64, the joints in the last axis. Tutorials: docs/python.md.
"""

try:
    import numpy  # noqa: F401
except ImportError as error:
    raise ImportError("leeway needs numpy, which this Python lacks: Debian's is python3-numpy") from error
try:
    from leeway import _leeway
except ImportError as error:
    raise ImportError(f"leeway's compiled part is missing or does not fit this Python ({error}); docs/python.md says how to build it for "
                      "this one") from error

from leeway._leeway import *  # noqa: F403
from leeway._leeway import __version__

__all__ = sorted(name for name in vars(_leeway) if not name.startswith("_"))
