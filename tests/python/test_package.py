# SPDX-License-Identifier: Apache-2.0
"""Tests of the package as a whole: its version, and a build without the renderer."""
import importlib.util

import kindling
import pytest


def test_version():
    assert kindling.__version__ == "0.1.0"


def test_rendering_needs_the_renderer():
    if importlib.util.find_spec("kindling._render") is not None:
        pytest.skip("this build has the renderer")
    with pytest.raises(ImportError, match="this build of kindling has no renderer"):
        kindling.render("scene.glb")
