"""The paper's figures: content, size and time in the paper, and the flags that render them here."""
# SPDX-License-Identifier: Apache-2.0
from dataclasses import dataclass, field

TURION = "AMD Turion X2 (2.0 GHz)"
TURION_GPU = "AMD Turion X2 (2.0 GHz) and ATI Radeon Xpress 1150, RenderMan"
WHITTED = ["--integrator", "whitted"]
SHADOWS_2, SHADOWS_8, GLOSS_3 = ["--light-samples", "2x2"], ["--light-samples", "8x8"], ["--glossy-samples", "3x3"]
MOVING = ["--time", "0"]  # of the animation; the camera has the shutter
AMBIENT_1 = "0.18,0.15,0.15"


@dataclass
class Way:
    """One way to render a scene."""
    name: str
    flags: list
    spp: int


@dataclass
class Figure:
    """size_px: that of the paper, or ours if it states none (size_stated False). scenes: (file without .glb, caption)."""
    number: str
    title: str
    paper: str  # what the paper did
    size_px: tuple
    scenes: list
    ways: list
    machine: str | None = None
    then: dict = field(default_factory=dict)  # time by scene, as the text gives it
    size_stated: bool = True


def whitted(name, spp, ambient, *flags):
    """ambient: radiance in place of light between diffuse surfaces."""
    return Way(f"Whitted, {name}", [*WHITTED, "--ambient", ambient, *flags], spp)


def path(spp, *flags):
    """Fireflies are trimmed, which so few samples would show."""
    return Way("path traced", ["--integrator", "path", "--outliers", "trim", *flags], spp)


GPU = (901, 738)
CPU = (301, 246)

FIGURES = [
    Figure("1", "The scene of the measurements", "The built-in scene of the kd-tree ray tracer: mirrors and glass, one ray per pixel. Rendered at 301 x 246 to "
           "compare the three tracers, at 900 x 675 to compare cores.", (900, 675), [("figure_01", "")],
           [whitted("one sample", 1, AMBIENT_1), whitted("16 samples", 16, AMBIENT_1), path(32)]),
    Figure("5", "Depth of field and antialiasing", "Eye positions are jittered; the nearest and the furthest sphere are blurred, the middle one is in focus.",
           (600, 500), [("figure_05", "")], [whitted("2 x 2 shadow feelers", 64, "0.12,0.14,0.17", *SHADOWS_2), path(64)], TURION,
           {"figure_05": "35.616 s"}),
    Figure("6", "Antialiasing", "Nine rays per pixel, each at a random place in its square of 3 x 3.", CPU, [("figure_06", "")],
           [whitted("2 x 2 shadow feelers", 9, "0.3,0.36,0.4", *SHADOWS_2), path(64)], TURION, size_stated=False),
    Figure("7", "Soft shadows", "Several shadow feelers, spread over the rectangular light as 8 x 8 squares, which was enough to reduce banding.", CPU,
           [("figure_07", "")], [whitted("8 x 8 shadow feelers", 4, "0.12,0.12,0.12", *SHADOWS_8, *GLOSS_3), path(128)], TURION, {"figure_07": "~35 s"}),
    Figure("8", "Depth of field, antialiasing and soft shadows", "All of the distributed effects in one scene.", CPU, [("figure_08", "")],
           [whitted("2 x 2 shadow feelers", 64, "0.13,0.14,0.16", *SHADOWS_2), path(128, "--caustics", "regularized")], TURION, {"figure_08": "11.170 s"}),
    Figure("9", "Whitted reflections", "Two spheres and the parallelogram below them mirror each other; one reflected ray, and its aliasing.", GPU,
           [("figure_09", "")], [whitted("one sample", 1, "0,0,0"), whitted("16 samples", 16, "0,0,0"), path(32)], TURION_GPU, {"figure_09": "4.525 s"}),
    Figure("10", "Glossy reflections", "Reflected rays are perturbed over a region of 3 x 3.", GPU, [("figure_10", "")],
           [whitted("3 x 3 glossy rays", 4, "0,0,0", *GLOSS_3), path(48)], TURION_GPU, {"figure_10": "9.134 s"}),
    Figure("11", "Glossy reflections with procedural textures", "Both spheres have a glossy surface shader, the left one with turbulence, the right one with a "
           "checkerboard.", GPU, [("figure_11", "")], [whitted("3 x 3 glossy rays", 4, "0.15,0.13,0.15", *GLOSS_3, *SHADOWS_2), path(48)],
           TURION_GPU),
    Figure("12", "Refraction and translucency", "A glossy sphere refracts the stripes of the patch behind it; on the right transmitted rays are perturbed over a "
           "region of 3 x 3, too.", GPU, [("figure_12_left", "clear"), ("figure_12_right", "translucent")],
           [whitted("3 x 3 glossy rays", 4, "0.22,0.22,0.22", *GLOSS_3, *SHADOWS_2), path(64)], TURION_GPU,
           {"figure_12_left": "4.450 s", "figure_12_right": "17.297 s"}),
    Figure("13", "A sphere behind a refractive cube", "Translucency again; the paper blames the time of the right one on refractions inside of the cube.", GPU,
           [("figure_13_left", "clear"), ("figure_13_right", "translucent")],
           [whitted("3 x 3 glossy rays", 4, "0.22,0.22,0.22", *GLOSS_3, *SHADOWS_2), path(64)], TURION_GPU,
           {"figure_13_left": "8.971 s", "figure_13_right": "61.380 s"}),
    Figure("14", "Depth of field by f-stop, focal length and focal distance", "The sphere in the back is in focus, the one in front is blurred.", GPU,
           [("figure_14", "")], [path(64, "--outliers", "keep")], TURION_GPU, {"figure_14": "10.308 s"}),
    Figure("15", "Motion blur", "Three moving spheres and the patch behind them, all textured with turbulence; glossy reflections leave a sparkling trail.", GPU,
           [("figure_15", "")], [path(64, *MOVING)], TURION_GPU, {"figure_15": "21.338 s"}),
    Figure("16", "All effects", "Everything that the GPU ray tracer can do in one scene.", GPU, [("figure_16", "")], [path(64, *MOVING)], TURION_GPU),
]


def find(numbers):
    """The figures of these numbers; exits with the list of figures if one is unknown."""
    import sys
    known = {figure.number: figure for figure in FIGURES}
    if unknown := [number for number in numbers if number not in known]:
        sys.exit(f"--figures: no figure {', '.join(unknown)}; there are {', '.join(known)}")
    return [figure for figure in FIGURES if figure.number in numbers]
