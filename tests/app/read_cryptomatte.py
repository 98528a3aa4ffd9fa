#!/usr/bin/env python3
"""Checks with readers that are not Kindling's that Cryptomatte layers sum to alpha.

    python3 -m venv readers && readers/bin/pip install cryptomatte-api OpenImageIO
    readers/bin/pip install --no-deps decryptomatte     # its requirements name an older OpenImageIO
    readers/bin/python tests/app/read_cryptomatte.py image.exr [--mattes FOLDER]

The image is rendered with `--cryptomatte object,material,asset --background transparent`. Each reader of PyPI that is
installed (cryptomatte-api, in C++, and decryptomatte, in Python) extracts the mattes of all names in the manifest. The
exit code is 0 if, for each reader and layer, the sums of all pixels agree with alpha, 1 if not, and 77 without any reader.
--mattes writes the mattes of the largest objects as PNG files.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import sys
from pathlib import Path

SKIPPED = 77
# Alpha is a half; ids beyond the levels of the file are missing, so that few pixels may have less.
TOLERANCE = 1e-3
ALLOWED_SHARE = 1e-3


def with_cryptomatte_api(path):
    """Returns {layer: {name: coverage}}."""
    import cryptomatte_api

    return {file.metadata().name(): file.masks() for file in cryptomatte_api.Cryptomatte.load(str(path))}


def with_decryptomatte(path):
    """Returns {layer: {name: coverage}}."""
    import decryptomatte

    image = decryptomatte.Decrypt(path)
    streams = list(image.sorted_metadata)
    if len(streams) > 1:  # it adds up the mattes of equal names
        raise ImportError("it tells no layers apart; render with one of them")
    return {streams[0]: image.get_mattes_by_names(image.list_layers())}


def alpha_of(path):
    import OpenImageIO as oiio

    image = oiio.ImageBuf(str(path))
    channel = list(image.spec().channelnames).index("A")
    return image.get_pixels(oiio.FLOAT)[:, :, channel]


def write_mattes(folder, layer, mattes, count=6):
    import OpenImageIO as oiio

    folder.mkdir(parents=True, exist_ok=True)
    for name, matte in sorted(mattes.items(), key=lambda entry: -entry[1].sum())[:count]:
        image = oiio.ImageBuf(oiio.ImageSpec(matte.shape[1], matte.shape[0], 1, "uint8"))
        image.set_pixels(oiio.ROI(), matte.astype("float32").reshape(*matte.shape, 1))
        safe = "".join(c if c.isalnum() else "_" for c in name)[:60]
        image.write(str(folder / f"{layer}_{safe}.png"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("image", type=Path)
    parser.add_argument("--mattes", type=Path, metavar="FOLDER", help="write PNG files there")
    options = parser.parse_args()
    try:
        import numpy as np

        alpha = alpha_of(options.image)
    except ImportError as error:
        print(f"skipped: {error}")
        return SKIPPED
    failed, readers = False, 0
    for reader in (with_cryptomatte_api, with_decryptomatte):
        try:
            layers = reader(options.image)
        except ImportError as error:
            print(f"{reader.__name__}: skipped: {error}")
            continue
        readers += 1
        for layer, mattes in layers.items():
            total = sum(matte.reshape(alpha.shape) for matte in mattes.values())
            away = np.abs(total - alpha)
            share = float((away > TOLERANCE).mean())
            failed |= share > ALLOWED_SHARE or total.max() > 1.0 + TOLERANCE
            print(
                f"{reader.__name__}: {layer}: {len(mattes)} names; largest difference to alpha {away.max():.2g}, "
                f"above {TOLERANCE:g} in {share:.2%} of the pixels"
            )
            if options.mattes:
                write_mattes(options.mattes, layer, mattes)
    if readers == 0:
        return SKIPPED
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
