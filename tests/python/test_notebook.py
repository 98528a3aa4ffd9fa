# SPDX-License-Identifier: Apache-2.0
"""Runs the package's notebook: every cell succeeds, and the notebook's images are made again."""
import os
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")
pytest.importorskip("matplotlib")
pytest.importorskip("trimesh")
pytest.importorskip("kindling._render")
NOTEBOOK = Path(os.environ.get("KINDLING_SOURCE_DIR", Path(__file__).resolve().parents[2])) / "renderer/python/example.ipynb"


def images(notebook):
    """How many images each cell shows."""
    cells = (cell for cell in notebook.cells if cell.cell_type == "code")
    return [sum("image/png" in output.get("data", {}) for output in cell.outputs) for cell in cells]


def test_notebook(tmp_path):
    shown = nbformat.read(NOTEBOOK, as_version=4)
    expected = images(shown)
    assert sum(expected) >= 3  # in the repository
    nbclient.NotebookClient(shown, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert images(shown) == expected
