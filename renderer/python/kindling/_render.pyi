# SPDX-License-Identifier: Apache-2.0
"""Kindling's renderer; use kindling.render."""

from collections.abc import Callable
from typing import Any

from numpy import float32
from numpy.typing import NDArray

class Options:
    size: tuple[int, int] | None
    spp: int | None
    seed: int
    camera: str
    orbit: tuple[float, float, float] | None
    target: tuple[float, float, float]
    yfov_deg: float | None
    time_s: float | None
    time_limit_s: float | None
    max_bounces: int
    transparent_background: bool
    aovs: list[str]

class RenderedImage:
    def layer(self, name: str, /) -> NDArray[float32]: ...
    def save(self, file: str, /) -> None: ...
    @property
    def interrupted(self) -> bool: ...

class Renderer:
    @staticmethod
    def load(
        file: str,
        env: str,
        env_color: tuple[float, float, float] | None,
        scene: str,
        variant: str,
        accelerator: str,
        threads: int,
        progress: Callable[..., Any] | None,
        warn: Callable[[str], None],
    ) -> Renderer: ...
    def render(
        self,
        options: Options,
        threads: int,
        progress: Callable[..., Any] | None,
        warn: Callable[[str], None],
    ) -> RenderedImage: ...
    def cameras(self) -> list[str]: ...
