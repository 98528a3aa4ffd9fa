# SPDX-License-Identifier: Apache-2.0
"""Renders glTF files and scenes of arrays to NumPy arrays, with the pixels of the command line."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Callable, Sequence
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from kindling._scene import Scene

try:
    from kindling import _render
except ImportError as error:
    _missing: Optional[ImportError] = error
else:
    _missing = None

__all__ = ["Image", "Renderer", "render"]

Progress = Callable[[str, float, float], Any]
Triple = tuple[float, float, float]


class Image:
    """A rendered image. Rows of pixels run from the top."""

    def __init__(self, image: Any) -> None:
        self._image = image

    @property
    def rgb(self) -> NDArray[np.float32]:
        """(height, width, 3) radiance, linear Rec. 709, premultiplied by alpha."""
        return self.layer("beauty")

    def layer(self, name: str) -> NDArray[np.float32]:
        """Return (height, width, 3) or (height, width): "beauty", or a layer that the render was asked for in `aovs`."""
        layer: NDArray[np.float32] = self._image.layer(name)
        return layer

    @property
    def interrupted(self) -> bool:
        """The render was ended before all samples were taken; the image holds those until then."""
        return bool(self._image.interrupted)

    def save(self, file: str | os.PathLike[str]) -> None:
        """Write a .png or .jpg through the default view transform, or an .exr with all layers."""
        self._image.save(os.fspath(file))

    def _repr_png_(self) -> bytes:
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "image.png")
            self.save(file)
            with open(file, "rb") as png:
                return png.read()


class Renderer:
    """A scene that is rendered several times: what does not change between images is prepared once.

    scene: a glTF file; its bytes, which refer to no other files; a kindling.Scene; or a trimesh.Trimesh or trimesh.Scene.
    env: file of an equirectangular environment; env_color: a constant one. scene_name, variant: which scene of the file,
    and which variant of its materials, by name or number. accelerator: "kdtree" or "embree". threads: 0 for all.
    progress: see render(). Raises ValueError for an invalid scene or setting, OSError if a file cannot be read; the
    messages are those of `kindling render`.
    """

    def __init__(
        self,
        scene: Any,
        *,
        env: str | os.PathLike[str] = "",
        env_color: Triple | None = None,
        scene_name: str = "",
        variant: str = "",
        accelerator: str = "kdtree",
        threads: int = 0,
        progress: Progress | None = None,
    ) -> None:
        if _missing is not None:
            raise ImportError(f"this build of kindling has no renderer: {_missing}") from _missing
        self._threads = threads
        with tempfile.TemporaryDirectory(prefix="kindling_") as folder:
            self._renderer = _render.Renderer.load(
                _file_of(scene, folder),
                os.fspath(env),
                env_color,
                scene_name,
                variant,
                accelerator,
                threads,
                progress,
                _warn,
            )

    @property
    def cameras(self) -> list[str]:
        """Names of the cameras of the file."""
        return list(self._renderer.cameras())

    def render(
        self,
        *,
        size: tuple[int, int] | None = None,
        spp: int | None = None,
        seed: int = 0,
        camera: str = "",
        orbit: Triple | None = None,
        target: Triple = (0.0, 0.0, 0.0),
        yfov: float | None = None,
        time: float | None = None,
        time_limit: float | None = None,
        max_bounces: int = 8,
        transparent_background: bool = False,
        aovs: Sequence[str] = (),
        progress: Progress | None = None,
    ) -> Image:
        """Render an image, with the same bits as `kindling render` with these settings.

        size: (width, height) in pixels. spp: samples per pixel (64). camera: a name or number. orbit: (theta in degrees,
        phi in degrees, radius in meters) about target. yfov: vertical field of view in degrees. time: of animations, in
        seconds. time_limit: of the render, in seconds. aovs: layers of `kindling render --aov`, as
        "alpha", "albedo", "normal", "depth", "position", "direct", "indirect", "samples", "variance".

        progress(phase, fraction, spp): called by this thread a few times a second; it ends the render by returning False,
        and the image then holds the samples so far. Ctrl-C and exceptions of progress end it too and are raised.
        """
        if size is not None and not all(1 <= side <= 65536 for side in size):
            raise ValueError(f"size: {size}, expected (width, height), each 1 to 65536")
        for name, value, low, high in (("spp", spp, 1, 1 << 20), ("seed", seed, 0, (1 << 31) - 1)):
            if value is not None and not low <= value <= high:
                raise ValueError(f"{name}: {value}, expected {low} to {high}")
        if not 0 <= max_bounces <= 1000:
            raise ValueError(f"max_bounces: {max_bounces}, expected 0 to 1000")
        for name, limit, end in (("time_limit", time_limit, float("inf")), ("yfov", yfov, 180.0)):
            if limit is not None and not 0.0 < limit < end:
                raise ValueError(f"{name}: {limit}, expected a number above 0 and below {end}")
        options = _render.Options()
        options.size = size
        options.spp = spp
        options.seed = seed
        options.camera = camera
        options.orbit = orbit
        options.target = target
        options.yfov_deg = yfov
        options.time_s = time
        options.time_limit_s = time_limit
        options.max_bounces = max_bounces
        options.transparent_background = transparent_background
        options.aovs = list(aovs)
        return Image(self._renderer.render(options, self._threads, progress, _warn))


def render(scene: Any, **settings: Any) -> Image:
    """Load a scene and render it: Renderer(scene, ...).render(...), whose arguments it takes."""
    of_renderer = ("env", "env_color", "scene_name", "variant", "accelerator", "threads")
    prepared = {name: settings.pop(name) for name in of_renderer if name in settings}
    return Renderer(scene, progress=settings.get("progress"), **prepared).render(**settings)


def _file_of(scene: Any, folder: str) -> str:
    """Return the name of the scene's file, which is written to folder if it is in memory."""
    if isinstance(scene, (str, os.PathLike)):
        return os.fspath(scene)
    if isinstance(scene, Scene):
        data = scene.to_glb()
    elif isinstance(scene, (bytes, bytearray, memoryview)):
        data = bytes(scene)
    elif type(scene).__module__.partition(".")[0] == "trimesh" and hasattr(scene, "export"):
        data = scene.export(file_type="glb")
    else:
        raise TypeError(f"scene: {type(scene).__name__}, expected a file, bytes, kindling.Scene, or a trimesh mesh or scene")
    file = os.path.join(folder, "scene.glb" if data[:4] == b"glTF" else "scene.gltf")
    with open(file, "wb") as written:
        written.write(data)
    return file


def _warn(message: str) -> None:
    warnings.warn(message, stacklevel=3)
