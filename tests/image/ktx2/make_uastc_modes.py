#!/usr/bin/env python3
"""Writes uastc_modes.ktx2: random blocks of every UASTC mode, partition and selector.

usage: make_uastc_modes.py FILE
"""
# SPDX-License-Identifier: Apache-2.0
import random
import struct
import sys

CODES = [(0x1, 4), (0x35, 6), (0x1D, 5), (0x3, 5), (0x13, 5), (0xB, 5), (0x1B, 5), (0x7, 5), (0x17, 5), (0xF, 5),
         (0x2, 3), (0x0, 2), (0x6, 3), (0x1F, 5), (0xD, 5), (0x5, 7), (0x15, 6), (0x25, 6), (0x9, 4)]
# mode: components, subsets, planes, endpoint bits, base (3 trits, 5 quints), hint bits
MODES = {0: (3, 1, 1, 6, 3, 15), 1: (3, 1, 1, 8, 1, 15), 2: (3, 2, 1, 4, 1, 15), 3: (3, 3, 1, 2, 3, 15),
         4: (3, 2, 1, 3, 5, 15), 5: (3, 1, 1, 8, 1, 15), 6: (3, 1, 2, 5, 5, 15), 7: (3, 2, 1, 3, 5, 15),
         9: (4, 2, 1, 4, 1, 23), 10: (4, 1, 1, 4, 3, 17), 11: (4, 1, 2, 4, 3, 17), 12: (4, 1, 1, 6, 3, 17),
         13: (4, 1, 2, 8, 1, 23), 14: (4, 1, 1, 8, 1, 23), 15: (2, 1, 1, 8, 1, 23), 16: (2, 2, 1, 8, 1, 23),
         17: (2, 1, 2, 8, 1, 23), 18: (3, 1, 1, 5, 1, 15)}
CODE_BITS = {3: [0, 2, 4, 5, 7, 8], 5: [0, 3, 5, 7]}
WIDTH = 18  # blocks


def block(mode, pattern=0, selector=0):
    fields = [CODES[mode]]
    if mode != 8:
        components, subsets, planes, _, base, hints = MODES[mode]
        fields.append((random.getrandbits(hints), hints))
        if subsets > 1:
            fields.append((pattern, 5 if subsets == 2 else 4))
        if planes > 1 and mode != 17:
            fields.append((selector, 2))
        values = components * 2 * subsets
        group = 5 if base == 3 else 3
        for first in range(0, values if base > 1 else 0, group):
            count = min(group, values - first)
            fields.append((random.randrange(base**count), CODE_BITS[base][count]))
    bits = position = 0
    for value, count in fields:
        bits |= value << position
        position += count
    bits |= random.getrandbits(128 - position) << position
    return struct.pack("<QQ", bits & (2**64 - 1), bits >> 64)


def all_blocks():
    blocks = [block(mode, i) for mode in (2, 4, 9, 16) for i in range(30)]
    blocks += [block(3, i) for i in range(11)] + [block(7, i) for i in range(19)]
    blocks += [block(mode, 0, i % (3 if mode == 6 else 4)) for mode in (6, 11, 13) for i in range(12)]
    blocks += [block(mode) for mode in (0, 1, 5, 8, 10, 12, 14, 15, 17, 18) for _ in range(12)]
    while len(blocks) % WIDTH:
        blocks.append(block(random.choice([0, 5, 10, 12, 18])))
    return blocks


def main():
    random.seed(19)
    blocks = all_blocks()
    data = b"".join(blocks)
    descriptor = struct.pack("<IIHHBBBBBBBBQ", 44, 0, 2, 40, 166, 1, 1, 0, 3, 3, 0, 0, 16)
    descriptor += struct.pack("<HBBIII", 0, 127, 3, 0, 0, 0xFFFFFFFF)  # channel 3: RGBA
    header = b"\xabKTX 20\xbb\r\n\x1a\n"
    header += struct.pack("<9I", 0, 1, WIDTH * 4, len(blocks) // WIDTH * 4, 0, 0, 1, 1, 0)
    header += struct.pack("<4I2Q", 104, len(descriptor), 0, 0, 0, 0)
    offset = (104 + len(descriptor) + 15) // 16 * 16
    header += struct.pack("<3Q", offset, len(data), len(data))
    with open(sys.argv[1], "wb") as file:
        file.write((header + descriptor).ljust(offset, b"\0") + data)


if __name__ == "__main__":
    main()
