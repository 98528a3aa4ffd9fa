"""Images as NumPy arrays, and the figures that compare a render with a golden."""
# SPDX-License-Identifier: Apache-2.0
import io
import struct
import subprocess
import sys
import tempfile
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import color_difference
import flip
import pixels

NO_READER = "neither oiiotool nor Pillow is installed (Debian: apt-get install openimageio-tools or python3-pil)"
OPAQUE = 254.5 / 255.0
# Encoded values between which tone mapping is inverted: not near black, where a byte is coarse, nor
# near white, where it saturates.
INVERTIBLE = (0.1, 0.95)
FILTER_REACH = 10  # pixels; flip.py's widest filter at its default resolution
# A map from no difference to all of it: black, violet, orange, pale yellow, of growing luminance.
MAP = np.array([[0, 0, 4], [40, 17, 89], [114, 31, 129], [183, 55, 121], [241, 96, 93], [254, 176, 120], [252, 253, 191]], float)


@dataclass
class Image:
    rgb: np.ndarray  # (height, width, 3)
    alpha: np.ndarray  # (height, width), 0 to 1


def read(path, size_px=None):
    """Reads any image that OpenImageIO reads, values as stored, resized to (width, height) if given. Without oiiotool Pillow
    reads PNG files of 8 bits."""
    if not size_px and not pixels.has_oiiotool():
        return read_by_pillow(path)
    with tempfile.TemporaryDirectory() as folder:
        flat = Path(folder) / "flat.tif"
        resize = ["--resize:filter=lanczos3", f"{size_px[0]}x{size_px[1]}"] if size_px else []
        subprocess.run([pixels.oiiotool(), "-q", str(path), *resize, "-d", "float", "--scanline", "--planarconfig", "contig",
                        "--compression", "none", "-o", str(flat)], check=True)
        width, height, channels, values = pixels.float_tiff(flat.read_bytes())
    values = np.nan_to_num(np.frombuffer(values, np.float32).reshape(height, width, channels), posinf=1e6)
    rgb = values[..., :3] if channels >= 3 else np.repeat(values[..., :1], 3, axis=-1)
    return Image(rgb, values[..., channels - 1] if channels in (2, 4) else np.ones((height, width), np.float32))


def read_by_pillow(path):
    """Colors are multiplied by alpha, as OpenImageIO does."""
    values = np.asarray(pillow().open(path), np.float32) / 255.0
    if values.ndim == 2 or values.shape[2] < 3:
        sys.exit(f"{path}: RGB or RGBA was expected; other images need oiiotool (Debian: openimageio-tools)")
    alpha = values[..., 3] if values.shape[2] == 4 else np.ones(values.shape[:2], np.float32)
    return Image(values[..., :3] * alpha[..., None], alpha)


def pillow():
    """Pillow's module Image."""
    try:
        import PIL.Image
    except ImportError:
        sys.exit(NO_READER)
    return PIL.Image


def tone_mapped(image):
    """Encodes a linear render as the goldens are: bytes."""
    return Image(color_difference.aces_8bit(image.rgb), image.alpha)


def resized(image, size_px):
    """An image of bytes, scaled to (width, height) as it is shown: encoded values are averaged. Needs oiiotool."""
    alpha = np.repeat((image.alpha * 255.0).round()[..., None], 3, axis=-1).astype(np.uint8)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "large.png"
        scaled = []
        for channels in (image.rgb, alpha):  # apart: OpenImageIO would multiply colors by alpha
            path.write_bytes(png(channels))
            scaled.append(np.clip(read(path, size_px).rgb, 0.0, 1.0))
    return Image((scaled[0] * 255.0).round().astype(np.uint8), scaled[1][..., 0])


def compare(ours, golden, whole):
    """Figures and the map of differences. ours: bytes; golden: encoded values in [0, 1]. Only pixels that both have opaque
    count (whole: all of them); elsewhere ours becomes the golden before FLIP looks, so that no edge arises there.

    flip, delta_e: means over those pixels. ratio: of the mean linear radiances, ours / golden, each channel, before tone
    mapping. silhouette: pixels that only one of the two covers, in parts of those that the golden covers.
    """
    shown = ours.rgb / 255.0
    wanted = np.round(np.clip(golden.rgb.astype(float), 0.0, 1.0) * 255.0) / 255.0  # bytes, too, so that equal pixels are exactly equal
    mask = np.ones(shown.shape[:2], bool) if whole else (golden.alpha >= OPAQUE) & (ours.alpha >= 0.999)
    covered = golden.alpha >= 0.5
    silhouette = 0.0 if whole else float(np.sum(covered != (ours.alpha >= 0.5)) / max(np.sum(covered), 1))
    if not mask.any():
        return {"flip": None, "delta_e": None, "ratio": [None] * 3, "silhouette": silhouette, "pixels": 0}, np.zeros(mask.shape)
    error = np.zeros(mask.shape)
    window = around(mask)
    error[window] = flip.flip(wanted[window], np.where(mask[..., None], shown, wanted)[window])
    error[~mask] = 0.0
    lab = [flip.linear_to_lab(flip.srgb_to_linear(p[mask])) for p in (wanted, shown)]
    return {"flip": float(error[mask].mean()), "delta_e": float(color_difference.ciede2000(*lab).mean()),
            "ratio": linear_ratio(shown[mask], wanted[mask]), "silhouette": silhouette, "pixels": int(mask.sum())}, error


def around(mask):
    """The window around the mask with the reach of FLIP's filters."""
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return (slice(max(rows[0] - FILTER_REACH, 0), rows[-1] + FILTER_REACH + 1),
            slice(max(columns[0] - FILTER_REACH, 0), columns[-1] + FILTER_REACH + 1))


def linear_ratio(ours, golden):
    """Ratio of mean radiances by channel, over the pixels where the tone mapping of both can be inverted."""
    low, high = INVERTIBLE
    usable = np.all((ours > low) & (ours < high) & (golden > low) & (golden < high), axis=-1)
    if np.sum(usable) < 16:
        return [None] * 3
    ours, golden = (color_difference.inverse_aces(p[usable]).mean(axis=0) for p in (ours, golden))
    return [float(a / b) if b > 0 else None for a, b in zip(ours, golden)]


def difference_png(error):
    """A PNG of a map of values in [0, 1], with a palette of 64 colors."""
    place = np.linspace(0.0, len(MAP) - 1, 64)
    palette = np.stack([np.interp(place, np.arange(len(MAP)), MAP[:, c]) for c in range(3)], axis=-1).round().astype(np.uint8)
    levels = (np.clip(error, 0.0, 1.0) * 63).round().astype(np.uint8)
    return png_file(levels[..., None], 3, [(b"PLTE", palette.tobytes())], 9)


def encode(rgb, alpha=None, quality=85):
    """Bytes of a WebP of (height, width, 3) bytes and alpha in [0, 1]."""
    if not pixels.has_oiiotool():
        written = io.BytesIO()
        pillow().fromarray(with_alpha(rgb, alpha)).save(written, "WEBP", quality=quality)
        return written.getvalue()
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "a.png", Path(folder) / "a.webp"
        source.write_bytes(png(rgb, alpha))
        subprocess.run([pixels.oiiotool(), "-q", "--no-autopremult", str(source), "--compression", f"webp:{quality}", "-o", str(target)],
                       check=True)
        return target.read_bytes()


def png(rgb, alpha=None):
    return png_file(with_alpha(rgb, alpha), 2 if alpha is None else 6, [], 1)


def with_alpha(rgb, alpha):
    return rgb if alpha is None else np.concatenate([rgb, (np.clip(alpha, 0, 1) * 255).round().astype(np.uint8)[..., None]], -1)


def png_file(channels, color_type, chunks, level):
    """channels: (height, width, count) bytes."""
    height, width = channels.shape[:2]
    rows = np.concatenate([np.zeros((height, 1), np.uint8), channels.reshape(height, -1)], axis=1)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, color_type, 0, 0, 0)
    body = b"".join(chunk(*c) for c in [(b"IHDR", header), *chunks, (b"IDAT", zlib.compress(rows.tobytes(), level)), (b"IEND", b"")])
    return b"\x89PNG\r\n\x1a\n" + body
