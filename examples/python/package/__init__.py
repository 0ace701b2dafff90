"""Geodesics on triangle meshes, and the images of optical tactile sensors.

Geometry is in float64, images and light in float32; both types go in. Lengths
are in the unit of the vertices; presets of sensors are in metres. Long work
takes `cancelled`, a callable that is told the share done and ends the work by
answering True; Ctrl-C ends it, too.
"""

from ._gelight import *  # noqa: F401,F403
from ._gelight import __version__  # noqa: F401
