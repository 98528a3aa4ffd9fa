# SPDX-License-Identifier: Apache-2.0
"""Kindling: ray tracing of triangle meshes over NumPy arrays, and rendering of glTF scenes.

The accelerators are in :mod:`kindling.accel`, a drop-in for trimesh's ray queries in :mod:`kindling.accel.trimesh`.
:func:`kindling.render` needs a build with the renderer. :func:`kindling.shootout` races the accelerators.
"""

from importlib.metadata import version as _version

from kindling import accel
from kindling._rendering import Image, Renderer, render
from kindling._shootout import shootout

__all__ = ["Image", "Renderer", "accel", "render", "shootout"]
__version__ = _version("kindling")
