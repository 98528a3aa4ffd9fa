# SPDX-License-Identifier: Apache-2.0
"""Kindling: ray tracing of triangle meshes over NumPy arrays.

The accelerators are in :mod:`kindling.accel`, a drop-in for trimesh's ray queries in :mod:`kindling.accel.trimesh`.
"""

from importlib.metadata import version as _version

from kindling import accel

__all__ = ["accel"]
__version__ = _version("kindling")
