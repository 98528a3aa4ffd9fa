#!/usr/bin/env python3
"""Hashes the texels that other decoders give for random blocks of compressed textures.

Prints block_hashes_tables.cpp.

usage: make_block_hashes.py > ../block_hashes_tables.cpp
       make_block_hashes.py --compare LIBRARY --blocks N [--seed N]

Needs the packages numpy, imagecodecs (bcdec), texture2ddecoder and astc-encoder-py (Arm's astcenc). Blocks are numbers of SplitMix64,
with the bits of modes set so that all of them occur; texels are compared at the precision of the other decoder.

--compare counts the blocks that a library decodes to other texels. It has one function,
int decode_blocks(uint32_t vk_format, const uint8_t* blocks, int count, uint32_t* texels), which writes the texels of all blocks in rows,
four channels each, with 0xffffffff for those of invalid blocks.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import ctypes
import sys

import astc_encoder
import imagecodecs
import numpy as np
import texture2ddecoder

BLOCKS = 2048
BC6H_CODES = [0, 1, 2, 6, 10, 14, 18, 22, 26, 30, 3, 7, 11, 15, 19, 31]  # the last two are reserved
ASTC_SIZES = [(4, 4), (5, 4), (5, 5), (6, 5), (6, 6), (8, 5), (8, 6), (8, 8), (10, 5), (10, 6), (10, 8), (10, 10), (12, 10), (12, 12)]
EIGHT_BYTES = (131, 133, 139, 147, 149, 153)


def split_mix(seed, count):
    """`count` numbers of SplitMix64."""
    with np.errstate(over="ignore"):
        z = np.uint64(seed) + np.arange(1, count + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return z ^ (z >> np.uint64(31))


def size_of(vk_format):
    if vk_format >= 1000066000:
        return ASTC_SIZES[vk_format - 1000066000]
    return ASTC_SIZES[(vk_format - 157) // 2] if vk_format >= 157 else (4, 4)


def make_blocks(vk_format, count, seed):
    width = 8 if vk_format in EIGHT_BYTES else 16
    blocks = split_mix(seed, count * width // 8).view(np.uint8).reshape(count, width).copy()
    index = np.arange(count)
    first = blocks[:, 0].astype(int)
    if vk_format in (143, 144):
        code = np.array(BC6H_CODES)[index % 16]
        blocks[:, 0] = np.where(code < 2, first & 0xFC, first & 0xE0) | code
    if vk_format == 145:
        mode = index % 9  # 8 is reserved
        blocks[:, 0] = ((first >> (mode + 1) << (mode + 1)) | (1 << mode)) & 255
    if vk_format >= 157:
        blocks[::32, 0] = 0xFC  # blocks of one color, whose extent is unknown
        blocks[::32, 1] = blocks[::32, 1] & 2 | 0xFD
        blocks[::32, 2:8] = 0xFF
    return blocks


def split(image, width, height):
    """Blocks by rows of texels, from an image that is one row of blocks."""
    rows, columns, channels = image.shape
    assert rows == height
    return image.reshape(height, columns // width, width, channels).transpose(1, 0, 2, 3)


def by_bcdec(data, count, code, channels):
    shape = (4, 4 * count) if channels == 1 else (4, 4 * count, channels)
    image = np.asarray(imagecodecs.bcn_decode(data, code, shape=shape)).reshape(4, 4 * count, channels)
    return split(image.view(np.uint16) if image.dtype == np.float16 else image, 4, 4).astype(np.uint32)


def by_texture2d(data, count, function):
    image = np.frombuffer(function(data, 4 * count, 4), np.uint8).reshape(4, 4 * count, 4)
    return split(image[..., [2, 1, 0, 3]], 4, 4).astype(np.uint32)


def by_astcenc(data, count, vk_format):
    width, height = size_of(vk_format)
    hdr = vk_format >= 1000066000
    profile = astc_encoder.ASTCProfile.HDR if hdr else [astc_encoder.ASTCProfile.LDR, astc_encoder.ASTCProfile.LDR_SRGB][(vk_format - 157) % 2]
    flags = astc_encoder.ASTCConfigFlags.DECOMPRESS_ONLY
    if not hdr:
        flags |= astc_encoder.ASTCConfigFlags.USE_DECODE_UNORM8
    context = astc_encoder.ASTCContext(astc_encoder.ASTCConfig(profile, width, height, 1, 100.0, flags))
    image = astc_encoder.ASTCImage(astc_encoder.ASTCType.F16 if hdr else astc_encoder.ASTCType.U8, width * count, height)
    raw = context.decompress(data, image, astc_encoder.ASTCSwizzle()).data
    return split(np.frombuffer(raw, np.uint16 if hdr else np.uint8).reshape(height, width * count, 4), width, height).astype(np.uint32)


def reference(vk_format, blocks):
    """Texels by another decoder."""
    data, count, bcn = blocks.tobytes(), len(blocks), imagecodecs.BCN.FORMAT
    if vk_format in (131, 133):
        texels = by_bcdec(data, count, bcn.BC1, 4)
        return texels[..., :3] if vk_format == 131 else texels
    if vk_format in (135, 137):
        return by_bcdec(data, count, bcn.BC2 if vk_format == 135 else bcn.BC3, 4)[..., :4 if vk_format == 135 else 3]
    if vk_format in (139, 141):
        return by_bcdec(data, count, bcn.BC4 if vk_format == 139 else bcn.BC5, 1 if vk_format == 139 else 2)
    if vk_format in (143, 144):
        texels = by_bcdec(data, count, bcn.BC6HU if vk_format == 143 else bcn.BC6HS, 3)
        return np.where(texels == 0x8000, 0, texels)  # zero has no sign
    if vk_format == 145:
        texels = by_bcdec(data, count, bcn.BC7, 4)
        valid = np.arange(count) % 9 != 8
        assert (texels[valid] == by_texture2d(data, count, texture2ddecoder.decode_bc7)[valid]).all(), "bcdec and texture2ddecoder disagree"
        return texels
    if vk_format == 147:
        return by_texture2d(data, count, texture2ddecoder.decode_etc2)[..., :3]
    if vk_format == 149:
        texels = by_texture2d(data, count, texture2ddecoder.decode_etc2a1)
        return np.where(texels[..., 3:] == 0, 0, texels)  # it leaves a color where alpha is 0
    if vk_format == 151:
        return by_texture2d(data, count, texture2ddecoder.decode_etc2a8)
    if vk_format in (153, 155):
        function = texture2ddecoder.decode_eacr if vk_format == 153 else texture2ddecoder.decode_eacrg
        return by_texture2d(data, count, function)[..., :1 if vk_format == 153 else 2]
    return by_astcenc(data, count, vk_format)


def as_reference(vk_format, texels):
    """Texels of Kindling at the precision of reference()."""
    if vk_format in (131, 137, 147):
        return texels[..., :3]
    if vk_format in (139, 141):
        return (texels[..., :1 if vk_format == 139 else 2] * 255 // 65535).astype(np.uint32)
    if vk_format in (143, 144):
        return np.where(texels[..., :3] == 0x8000, 0, texels[..., :3])
    if vk_format in (153, 155):  # the upper 8 of 11 bits
        return ((texels[..., :1 if vk_format == 153 else 2].astype(np.uint64) * 2047 + 32767) // 65535 >> 3).astype(np.uint32)
    return texels


def counted(vk_format, texels):
    """Which blocks are compared: of ASTC those without a color of errors (white, magenta), or negative or infinite halves."""
    if vk_format < 157:
        return np.ones(len(texels), bool)
    if vk_format < 1000066000:
        error = (texels == 255).all(axis=3) | (texels == [255, 0, 255, 255]).all(axis=3)
        return ~error.reshape(len(texels), -1).any(axis=1)
    return ~((texels >= 0x8000) | ((texels & 0x7C00) == 0x7C00)).reshape(len(texels), -1).any(axis=1)


def fnv(values):
    value = 0xCBF29CE484222325
    for number in values.astype("<u2").tobytes():
        value = (value ^ number) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return value


FORMATS = [131, 133, 135, 137, 139, 141, 143, 144, 145, 147, 149, 151, 153, 155, *range(157, 185), *range(1000066000, 1000066014)]


def compare(library, count, seed):
    decode = ctypes.CDLL(library).decode_blocks
    total = 0
    for vk_format in FORMATS:
        width, height = size_of(vk_format)
        blocks = make_blocks(vk_format, count, seed + vk_format)
        texels = np.zeros((count, height, width, 4), np.uint32)
        decode(vk_format, blocks.ctypes.data_as(ctypes.c_void_p), count, texels.ctypes.data_as(ctypes.c_void_p))
        expected = reference(vk_format, blocks)
        used = counted(vk_format, expected)
        equal = (as_reference(vk_format, texels) == expected).reshape(count, -1).all(axis=1)
        # Errors of the other decoder must be invalid here, or equal and just look like errors. It
        # refuses negative halves in blocks of one color.
        one_color = (blocks[:, 0] == 0xFC) & (blocks[:, 1] & 1 == 1)
        accepted = int(((texels != 0xFFFFFFFF).reshape(count, -1).all(axis=1) & ~used & ~equal & ~one_color).sum())
        total += int(used.sum())
        print(f"{vk_format}: {used.sum()} blocks compared, {(used & ~equal).sum()} differ; {accepted} accepted that the other refuses")
    print(f"{total} blocks compared")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--compare", metavar="LIBRARY")
    parser.add_argument("--blocks", type=int, default=BLOCKS)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    if options.compare:
        compare(options.compare, options.blocks, options.seed)
        return 0
    print("// Hashes of texels that other decoders give for random blocks: output of ktx2/make_block_hashes.py.")
    print("// SPDX-License-Identifier: Apache-2.0")
    print('#include "tests/image/block_hashes.h"\n\nnamespace kindling::test {\n')
    print("const std::vector<BlockHash>& block_hashes() {\n  static const std::vector<BlockHash> hashes = {")
    for vk_format in FORMATS:
        texels = reference(vk_format, make_blocks(vk_format, BLOCKS, vk_format))
        used = counted(vk_format, texels)
        print(f"      {{{vk_format}, {used.sum()}, 0x{fnv(texels[used]):016x}}},")
    print("  };\n  return hashes;\n}\n\n} // namespace kindling::test")
    return 0


if __name__ == "__main__":
    sys.exit(main())
