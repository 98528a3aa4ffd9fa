# SPDX-License-Identifier: Apache-2.0
"""Kindling: ray tracing of triangle meshes over NumPy arrays, and rendering of glTF scenes.

The accelerators are in :mod:`kindling.accel`, a drop-in for trimesh's ray queries in :mod:`kindling.accel.trimesh`.
:class:`kindling.Scene` makes a scene of arrays, :func:`kindling.render` renders it or a file; both need a build with the
renderer. :func:`kindling.shootout` races the accelerators.
"""

from importlib.metadata import version as _version

from kindling import accel
from kindling._rendering import Image, Renderer, render
from kindling._scene import Material, Scene
from kindling._shootout import shootout

__all__ = ["Image", "Material", "Renderer", "Scene", "accel", "render", "shootout"]
__version__ = _version("kindling")
