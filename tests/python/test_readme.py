# SPDX-License-Identifier: Apache-2.0
"""Runs the examples of the package's README, as somebody would paste them."""
import os
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

README = Path(os.environ.get("KINDLING_SOURCE_DIR", Path(__file__).resolve().parents[2])) / "renderer/python/README.md"
EXAMPLES = re.findall(r"^```python\n(.*?)^```", README.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def test_there_are_examples():
    assert len(EXAMPLES) >= 4


@pytest.mark.parametrize("number", range(len(EXAMPLES)))
def test_example(number, tmp_path, monkeypatch, capsys):
    example = EXAMPLES[number]
    assert len(example.splitlines()) <= 12
    if "trimesh" in example:
        pytest.importorskip("trimesh")
    if "kindling.render" in example:
        pytest.importorskip("kindling._render")
        shutil.copy(README.parents[2] / "scenes/cornell_box.glb", tmp_path / "scene.glb")
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(compile(example, f"README.md, example {number + 1}", "exec"), names)  # noqa: S102
    shown = re.findall(r"^print\(.*\) +# (.*)$", example, re.MULTILINE)  # the output that the README shows
    assert capsys.readouterr().out.splitlines() == shown
    assert any(isinstance(value, np.ndarray) or shown for value in names.values())
