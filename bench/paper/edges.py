"""Figure 6: one sample, nine jittered ones, and our sampler and filter, and a converged image."""
# SPDX-License-Identifier: Apache-2.0
import numpy as np

import fidelity_images
import figures
import tracers

SCENE, SIZE = "figure_06", (301, 246)
COMMON = next(way.flags for figure in figures.find(["6"]) for way in figure.ways if "whitted" in way.flags)
BOX, OURS = ["--filter", "box"], ["--filter", "blackman-harris"]
WAYS = {
    "one sample": (1, ["--sampler", "jittered", *BOX]),
    "3 x 3, jittered, box filter": (9, ["--sampler", "jittered", *BOX]),
    "9 samples, Sobol, box filter": (9, ["--sampler", "sobol", *BOX]),
    "9 samples, Sobol, Blackman-Harris filter": (9, ["--sampler", "sobol", *OURS]),
    "9 samples, blue noise, Blackman-Harris filter": (9, ["--sampler", "blue-noise", *OURS]),
}
CROPS = [(0.80, 0.27, 0.10), (0.05, 0.46, 0.10)]  # center x, center y, width; in parts of the image


def compare(bench, reference_spp):
    size = bench.scaled(SIZE)
    references, found = {}, []
    for name, (spp, flags) in WAYS.items():
        key = tuple(flags[flags.index("--filter"):])
        if key not in references:
            bench.say(f"figure 6: converged, {key[1]} filter")
            references[key] = _read(bench.render(SCENE, size, reference_spp, [*COMMON, "--sampler", "sobol", *key]))
        bench.say(f"figure 6: {name}")
        result = bench.render(SCENE, size, spp, [*COMMON, *flags])
        rgb = _read(result)
        difference = rgb - references[key]
        found.append({"name": name, "spp": spp, "seconds": result.render_s, "rmse": float(np.sqrt(np.mean(difference ** 2))),
                      "crops": [crop(rgb, *place) for place in CROPS], "image": tracers.encode(rgb)})
    found.append({"name": f"converged ({reference_spp} samples), Blackman-Harris filter", "spp": reference_spp, "seconds": None, "rmse": 0.0,
                  "crops": [crop(references[tuple(OURS)], *place) for place in CROPS], "image": tracers.encode(references[tuple(OURS)])})
    return found


def _read(result):
    return fidelity_images.read(result.image).rgb.astype(float)


def crop(rgb, x, y, width):
    """A square of the image, without loss, to be shown enlarged."""
    side = max(round(width * rgb.shape[1]), 4)
    left = min(max(round(x * rgb.shape[1]) - side // 2, 0), rgb.shape[1] - side)
    top = min(max(round(y * rgb.shape[0]) - side // 2, 0), rgb.shape[0] - side)
    return fidelity_images.png(np.round(np.clip(rgb[top:top + side, left:left + side], 0, 1) * 255).astype(np.uint8))
