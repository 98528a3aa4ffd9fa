# SPDX-License-Identifier: Apache-2.0
"""Kindling's accelerators; use kindling.accel."""

from collections.abc import Sequence
from typing import Any

from numpy import bool_, float32, int32, int64
from numpy.typing import NDArray

def description(name: str) -> str: ...

class Scene:
    @staticmethod
    def make(
        meshes: Sequence[tuple[NDArray[Any], NDArray[Any]]],
        instances: Sequence[tuple[int, NDArray[Any]]] | None,
        accelerator: str,
        quality: str,
        robust: bool,
        threads: int,
    ) -> Scene: ...
    def intersect(
        self, origins: NDArray[Any], directions: NDArray[Any], t_min: NDArray[Any], t_max: NDArray[Any], threads: int, /
    ) -> tuple[NDArray[float32], NDArray[float32], NDArray[float32], NDArray[int32], NDArray[int32], NDArray[int32]]: ...
    def occluded(
        self, origins: NDArray[Any], directions: NDArray[Any], t_min: NDArray[Any], t_max: NDArray[Any], threads: int, /
    ) -> NDArray[bool_]: ...
    def all_hits(
        self,
        origins: NDArray[Any],
        directions: NDArray[Any],
        t_min: NDArray[Any],
        t_max: NDArray[Any],
        limit: int,
        threads: int,
        /,
    ) -> tuple[
        NDArray[int64],
        NDArray[int64],
        NDArray[float32],
        NDArray[float32],
        NDArray[float32],
        NDArray[int32],
        NDArray[int32],
        NDArray[int32],
        NDArray[bool_],
    ]: ...
    def statistics(self) -> dict[str, Any]: ...
    def bounds(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]: ...
