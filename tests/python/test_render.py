# SPDX-License-Identifier: Apache-2.0
"""Tests of kindling.render: arrays, the command line's bits, progress, cancelling, errors."""
import os
import signal
import subprocess
import threading
from pathlib import Path

import kindling
import numpy as np
import pytest

pytest.importorskip("kindling._render")
SCENES = Path(os.environ.get("KINDLING_SOURCE_DIR", Path(__file__).resolve().parents[2])) / "scenes"
SCENE = SCENES / "cornell_box.glb"
SMALL = {"size": (40, 30), "spp": 4}


def test_arrays_and_layers():
    image = kindling.render(SCENE, **SMALL, aovs=["depth", "normal", "samples"])
    assert image.rgb.shape == (30, 40, 3) and image.rgb.dtype == np.float32
    assert np.isfinite(image.rgb).all() and image.rgb.mean() > 0.01
    assert image.layer("depth").shape == (30, 40) and image.layer("depth").max() > 0
    assert image.layer("normal").shape == (30, 40, 3)
    assert (image.layer("samples") == 4).all()
    assert not image.interrupted
    assert image._repr_png_()[:8] == b"\x89PNG\r\n\x1a\n"


def test_bits_do_not_depend_on_threads_or_earlier_images():
    renderer = kindling.Renderer(SCENE, threads=1)
    first = renderer.render(**SMALL).rgb
    other = renderer.render(**SMALL, seed=7).rgb
    assert not np.array_equal(first, other)
    np.testing.assert_array_equal(renderer.render(**SMALL).rgb, first)
    np.testing.assert_array_equal(kindling.render(SCENE, **SMALL, threads=3).rgb, first)


def test_pixels_are_those_of_the_command_line(tmp_path):
    program = os.environ.get("KINDLING_PROGRAM")
    if not program:
        pytest.skip("KINDLING_PROGRAM is not set")
    subprocess.run([program, "render", SCENE, "-o", tmp_path / "a.png", "--size", "40x30", "--spp", "4"], check=True, capture_output=True)
    kindling.render(SCENE, **SMALL).save(tmp_path / "b.png")
    assert pixels(tmp_path / "a.png") == pixels(tmp_path / "b.png")


def pixels(file):
    """The compressed pixels of a PNG, without its metadata."""
    data, at, found = file.read_bytes(), 8, b""
    while at < len(data):
        size = int.from_bytes(data[at:at + 4], "big")
        if data[at + 4:at + 8] == b"IDAT":
            found += data[at + 8:at + 8 + size]
        at += size + 12
    return found


def test_progress_is_reported_by_the_calling_thread():
    calls = []
    kindling.render(SCENE, size=(200, 150), spp=64, progress=lambda *call: calls.append((threading.get_ident(), *call)))
    assert {call[0] for call in calls} == {threading.get_ident()}
    assert all(0.0 <= call[2] <= 1.0 for call in calls)
    assert "render" in {call[1] for call in calls}


def test_progress_cancels():
    image = kindling.render(SCENE, size=(640, 480), spp=100000, progress=lambda phase, fraction, spp: phase != "render")
    assert image.interrupted and image.rgb.shape == (480, 640, 3)


def test_exceptions_of_progress_are_raised():
    def fail(phase, fraction, spp):
        raise KeyError(phase)
    with pytest.raises(KeyError):
        kindling.render(SCENE, size=(640, 480), spp=100000, progress=fail)


def test_ctrl_c_ends_a_render():
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # shells ignore it for jobs in the background
    timer = threading.Timer(1.0, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        kindling.render(SCENE, size=(640, 480), spp=1000000)
    signal.signal(signal.SIGINT, before)


def test_time_limit_and_cameras():
    renderer = kindling.Renderer(SCENE, env_color=(0.5, 0.5, 0.5))
    assert renderer.render(size=(32, 32), time_limit=0.2).rgb.shape == (32, 32, 3)
    around = renderer.render(**SMALL, orbit=(60, 30, 5), yfov=40, max_bounces=1, transparent_background=True, aovs=["alpha"])
    assert 0.0 <= around.layer("alpha").min() <= around.layer("alpha").max() <= 1.0 + 1e-6
    assert all(isinstance(name, str) for name in renderer.cameras)


@pytest.mark.parametrize("call, error, text", [
    (lambda: kindling.render("missing.glb"), OSError, "missing.glb"),
    (lambda: kindling.render(SCENE, camera="none of these", **SMALL), ValueError, "none of these"),
    (lambda: kindling.render(SCENE, size=(0, 4)), ValueError, r"size: \(0, 4\), expected"),
    (lambda: kindling.render(SCENE, spp=0), ValueError, "spp: 0, expected 1 to"),
    (lambda: kindling.render(SCENE, seed=-1), ValueError, "seed: -1"),
    (lambda: kindling.render(SCENE, time_limit=0), ValueError, "time_limit: 0, expected"),
    (lambda: kindling.render(SCENE, aovs=["none"], **SMALL), ValueError, "unknown layer 'none'; use beauty, alpha"),
    (lambda: kindling.render(SCENE, accelerator="bvh"), ValueError, "'bvh', expected"),
    (lambda: kindling.render(SCENE, sizes=(4, 4)), TypeError, "sizes"),
])
def test_errors(call, error, text):
    with pytest.raises(error, match=text):
        call()


def test_save_refuses_unknown_formats(tmp_path):
    image = kindling.render(SCENE, **SMALL)
    image.save(tmp_path / "image.exr")
    assert (tmp_path / "image.exr").stat().st_size > 1000
    with pytest.raises(ValueError, match="image.xyz"):
        image.save(tmp_path / "image.xyz")
