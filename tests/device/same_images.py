#!/usr/bin/env python3
"""Renders scenes by the CPU and by another device; the accumulations must have the same bits.

usage: same_images.py KINDLING SCENES [--device NAME] [--size WxH] [--spp N] [FLAG]...
SCENES is a folder whose .glb and .gltf files are rendered, or one such file. Other flags are passed on.
Exit code 0 if all images are the same, 1 with a line for each other one."""
# SPDX-License-Identifier: Apache-2.0
import argparse
import pathlib
import subprocess
import sys
import tempfile

# Folders of files that shall not load.
LEFT_OUT = {"broken", "images"}


def scenes_in(place):
    if place.is_file():
        return [place]
    found = [path for pattern in ("*.glb", "*.gltf") for path in place.rglob(pattern)]
    return sorted(path for path in found if not LEFT_OUT & set(path.relative_to(place).parts[:-1]))


def render(kindling, scene, device, flags, folder):
    """The path of the image, or None with a message."""
    image = folder / f"{device}.exr"
    image.unlink(missing_ok=True)
    result = subprocess.run([kindling, "render", scene, "--device", device, "-o", image, "--quiet", *flags], check=False,
                            capture_output=True, text=True)
    if result.returncode == 0:
        return image
    print(f"{scene}: --device {device} ends with code {result.returncode}: {result.stderr.strip()}", file=sys.stderr)
    return None


def pixels_of(image):
    """The compressed pixels of an EXR file: all of it but the header, which tells times."""
    data = image.read_bytes()
    at = 8  # magic number and version
    while data[at] != 0:  # an attribute: name, type, size and value
        name_end = data.index(0, at)
        type_end = data.index(0, name_end + 1)
        at = type_end + 5 + int.from_bytes(data[type_end + 1 : type_end + 5], "little")
    first_chunk = int.from_bytes(data[at + 1 : at + 9], "little")  # the first entry of the table of chunks
    return data[first_chunk:]


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("kindling", type=pathlib.Path)
    parser.add_argument("scenes", type=pathlib.Path)
    parser.add_argument("--device", default="host")
    parser.add_argument("--size", default="40x28")
    parser.add_argument("--spp", default="2")
    arguments, more = parser.parse_known_args()
    flags = ["--size", arguments.size, "--spp", arguments.spp, "--exr-float", "--aov",
             "albedo,normal,depth,position,variance,samples,denoising_albedo,denoising_normal,object_id,material_id,depth_nearest,position_nearest,uv", *more]
    if "whitted" not in more:
        flags += ["--cryptomatte", "object,material,asset"]
    scenes = scenes_in(arguments.scenes)
    different = 0
    with tempfile.TemporaryDirectory() as folder:
        for scene in scenes:
            images = [render(arguments.kindling, scene, device, flags, pathlib.Path(folder)) for device in ("cpu", arguments.device)]
            if None in images:
                different += 1
                continue
            if pixels_of(images[0]) != pixels_of(images[1]):
                print(f"{scene}: the image of --device {arguments.device} differs", file=sys.stderr)
                different += 1
    print(f"{len(scenes)} scenes, {different} different")
    sys.exit(1 if different or not scenes else 0)


if __name__ == "__main__":
    main()
