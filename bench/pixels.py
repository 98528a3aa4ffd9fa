"""Reading of images, through oiiotool where it is installed, and measures of their noise."""
# SPDX-License-Identifier: Apache-2.0
import array
import os
import shutil
import struct
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import image_files

TRIMMED_FRACTION = 0.001  # worst pixels left out of a noise figure: single fireflies would decide it alone
RADIANCE_FLOOR = 0.01  # of the squared mean, added to the denominator so that black pixels do not count without limit


@dataclass
class Image:
    width: int
    height: int
    rgb: array.array  # floats, interleaved, rows from the top

    def mean(self):
        """Mean of each channel."""
        count = self.width * self.height
        return [sum(self.rgb[channel::3]) / count for channel in range(3)]


def read_rgb(path):
    """Channels R, G, B of any image that OpenImageIO reads, linear values as stored; without oiiotool, of an EXR file."""
    if not has_oiiotool():
        return read_without_oiiotool(path)
    with tempfile.TemporaryDirectory() as folder:
        flat = os.path.join(folder, "flat.tif")
        subprocess.run([oiiotool(), "-q", str(path), "--ch", "R,G,B", "-d", "float", "--scanline", "--planarconfig", "contig",
                        "--compression", "none", "-o", flat], check=True)
        with open(flat, "rb") as file:
            return parse_float_tiff(file.read())


def read_without_oiiotool(path):
    try:
        width, height, channels, values = image_files.read(Path(path))
    except image_files.Unsupported as error:
        sys.exit(str(error))
    rgb = array.array("f", bytes(12 * width * height))
    for channel in range(3):
        rgb[channel::3] = values[channel::channels]
    return Image(width, height, rgb)


def parse_float_tiff(data):
    """An uncompressed, striped, interleaved RGB float TIFF in the machine's byte order."""
    width, height, channels, rgb = float_tiff(data)
    assert channels == 3, "not an RGB TIFF"
    return Image(width, height, rgb)


def float_tiff(data):
    """(width, height, channels, values) of an uncompressed, striped, interleaved float TIFF; values in the machine's byte order."""
    order = {b"II": "<", b"MM": ">"}[data[:2]]
    directory = struct.unpack_from(order + "I", data, 4)[0]
    tags = {}
    for i in range(struct.unpack_from(order + "H", data, directory)[0]):
        tag, kind, count = struct.unpack_from(order + "HHI", data, directory + 2 + 12 * i)
        letter = {3: "H", 4: "I"}.get(kind)
        if letter:
            size = struct.calcsize(order + str(count) + letter)
            offset = directory + 2 + 12 * i + 8
            if size > 4:
                offset = struct.unpack_from(order + "I", data, offset)[0]
            tags[tag] = struct.unpack_from(order + str(count) + letter, data, offset)
    width, height, channels = tags[256][0], tags[257][0], tags[277][0]
    assert tags[259][0] == 1 and tags[339][0] == 3, "not an uncompressed float TIFF"
    values = array.array("f")
    for offset, size in zip(tags[273], tags[279]):
        values.frombytes(data[offset:offset + size])
    if (order == "<") != (sys.byteorder == "little"):
        values.byteswap()
    assert len(values) == channels * width * height
    return width, height, channels, values


def mean_image(images):
    """The pixel-wise mean of images of one size."""
    first = images[0]
    count = len(images)
    return Image(first.width, first.height, array.array("f", (sum(values) / count for values in zip(*(p.rgb for p in images)))))


def noise(images, scale):
    """Relative variance of each pixel, estimated from two or more images with independent seeds, ascending: variance /
    (R^2 + 0.01 mean(R)^2), the mean over the channels. The variance is that of the images among themselves, so a
    difference of model against `scale`, R, does not count as noise."""
    count = len(images)
    assert count >= 2
    return _relative(scale, ((sum((v - sum(values) / count) ** 2 for v in values) / (count - 1))
                             for values in zip(*(p.rgb for p in images))))


def error(images, reference, scale=None):
    """Relative squared error of each pixel against a reference, ascending, the mean over the images: noise, bias and the
    noise of the reference together. Errors are relative to `scale` (None: to the reference)."""
    count = len(images)
    return _relative(scale or reference, (sum((v - r) ** 2 for v in values) / count
                                 for r, *values in zip(reference.rgb, *(p.rgb for p in images))))


def difference(images, others, scale):
    """Root of the mean relative squared difference (0.1: a tenth) between the means of two groups of images, each of two or more,
    less the part that their noise explains; the worst pixels left out."""
    found = rel_mse(error([mean_image(images)], mean_image(others), scale))
    explained = sum(rel_mse(noise(group, scale)) / len(group) for group in (images, others))
    return max(found - explained, 0.0) ** 0.5


def _relative(scale, squares):
    mean = sum(scale.rgb) / len(scale.rgb)
    floor = RADIANCE_FLOOR * mean * mean + 1e-20
    errors = [square / (r * r + floor) for r, square in zip(scale.rgb, squares)]
    return sorted((errors[i] + errors[i + 1] + errors[i + 2]) / 3.0 for i in range(0, len(errors), 3))


def rel_mse(ascending, dropped=TRIMMED_FRACTION):
    """The mean of the pixels of noise() or error() without the worst ones."""
    counted = ascending[:len(ascending) - int(len(ascending) * dropped)]
    return sum(counted) / len(counted)


def small_png(path, width, gain):
    """An image times `gain` through the sRGB curve, `width` pixels wide (None: as it is), as the bytes of a PNG."""
    with tempfile.TemporaryDirectory() as folder:
        png = os.path.join(folder, "small.png")
        shrink = ["--resize", f"{width}x0"] if width else []
        subprocess.run([oiiotool(), "-q", str(path), "--ch", "R,G,B", *shrink, "--mulc", str(gain), "--clamp:min=0:max=1",
                        "--colorconvert", "linear", "sRGB", "-d", "uint8", "-o", png], check=True)
        with open(png, "rb") as file:
            return file.read()


def has_oiiotool():
    return shutil.which("oiiotool") is not None


def oiiotool():
    return shutil.which("oiiotool") or sys.exit("oiiotool is not installed (Debian: apt-get install openimageio-tools)")
