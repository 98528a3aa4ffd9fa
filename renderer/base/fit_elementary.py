#!/usr/bin/env python3
"""Fits the polynomials of elementary.h, computes its tables and writes elementary_coefficients.h.

usage: fit_elementary.py > elementary_coefficients.h
       fit_elementary.py --check    verifies that the header beside it is the one that the fit gives

Minimax polynomials by the exchange algorithm of E. Remez (1934), "Sur la determination des polynomes
d'approximation de degre donnee", which here exchanges all points, in 60 digits. Coefficients are rounded to
double at the end; the comments have the largest error of the rounded polynomials. Needs mpmath (Debian:
python3-mpmath)."""
# SPDX-License-Identifier: Apache-2.0
import pathlib
import struct
import sys

from mpmath import mp, mpf, acos, asin, atan, atanh, cos, log, pi, sin, sqrt

mp.dps = 60


def horner(coefficients, x):
    result = mpf(0)
    for c in reversed(coefficients):
        result = result * x + c
    return result


def remez(f, low, high, count):
    """Polynomial of `count` coefficients with the least maximum of w |f - p| over [low, high]; w = x if low is 0, else 1."""
    low, high = mpf(low), mpf(high)
    weight = (lambda x: x / high) if low == 0 else (lambda x: mpf(1))
    if low == 0:
        low = high / 50  # errors below have no weight
    middle, half = (low + high) / 2, (high - low) / 2
    nodes = [middle - half * cos(pi * i / count) for i in range(count + 1)]
    grid = [middle - half * cos(pi * i / (40 * count)) for i in range(40 * count + 1)]
    values = [f(x) for x in grid]
    for _ in range(30):
        # p(x_i) + (-1)^i e / w(x_i) = f(x_i)
        matrix = mp.matrix(count + 1, count + 1)
        right = mp.matrix(count + 1, 1)
        for i, x in enumerate(nodes):
            for j in range(count):
                matrix[i, j] = x**j
            matrix[i, count] = (-1) ** i / weight(x)
            right[i] = f(x)
        solution = mp.lu_solve(matrix, right)
        coefficients, level = list(solution[:count]), abs(solution[count])
        errors = [weight(x) * (v - horner(coefficients, x)) for x, v in zip(grid, values)]
        # The largest error between two changes of sign.
        nodes, best = [], None
        for x, e in zip(grid, errors):
            if best is not None and (e > 0) != (best[1] > 0):
                nodes.append(best[0])
                best = None
            if best is None or abs(e) > abs(best[1]):
                best = (x, e)
        nodes.append(best[0])
        if len(nodes) != count + 1:
            raise ArithmeticError(f"{len(nodes)} alternations instead of {count + 1}")
        if max(abs(e) for e in errors) < level * mpf("1.001"):
            return coefficients
    raise ArithmeticError("no convergence")


def off_zero(f, series):
    """f, but near 0 the first terms of its series, where f would divide 0 by 0."""
    return lambda x: horner(series, x) if abs(x) < mpf(10) ** -12 else f(x)


LN2 = log(mpf(2))


# Powers 2^(i / 64), and logarithms of 128 intervals of the mantissa.
EXP2_ENTRIES = 64
LOG2_ENTRIES = 128


def polynomials():
    third, fifth = mpf(1) / 3, mpf(1) / 5
    exp2_end, log2_end = mpf("1.0000001") / (2 * EXP2_ENTRIES), mpf("1.0000001") / (2 * LOG2_ENTRIES)
    log2_near = off_zero(lambda r: log(1 + r) / (LN2 * r), [1 / LN2, -1 / (2 * LN2), 1 / (3 * LN2)])
    exp2_tail = off_zero(lambda r: (mpf(2) ** r - 1 - LN2 * r) / r**2, [LN2**2 / 2, LN2**3 / 6, LN2**4 / 24, LN2**5 / 120])
    exp_tail = off_zero(lambda r: (mp.exp(r) - 1 - r) / r**2, [mpf(1) / 2, mpf(1) / 6, mpf(1) / 24, mpf(1) / 120])

    def atanh_of(z):  # (atanh(s) / s - 1) / s^2 of z = s^2
        return (atanh(sqrt(z)) / sqrt(z) - 1) / z

    log_series = off_zero(atanh_of, [third, fifth, mpf(1) / 7])
    log_rest = off_zero(lambda z: (atanh_of(z) - third) / z, [fifth, mpf(1) / 7, mpf(1) / 9])
    sin_series = off_zero(lambda z: (sin(sqrt(z)) / sqrt(z) - 1) / z, [-mpf(1) / 6, mpf(1) / 120, -mpf(1) / 5040])
    cos_series = off_zero(lambda z: (cos(sqrt(z)) - 1) / z, [-mpf(1) / 2, mpf(1) / 24, -mpf(1) / 720])
    cos_rest = off_zero(lambda z: (cos(sqrt(z)) - 1 + z / 2) / z**2, [mpf(1) / 24, -mpf(1) / 720, mpf(1) / 40320])
    asin_series = off_zero(lambda z: (asin(sqrt(z)) / sqrt(z) - 1) / z, [mpf(1) / 6, mpf(3) / 40, mpf(15) / 336])
    atan_series = off_zero(lambda z: (atan(sqrt(z)) / sqrt(z) - 1) / z, [-third, fifth, -mpf(1) / 7])

    log_end = ((sqrt(mpf(2)) - 1) / (sqrt(mpf(2)) + 1)) ** 2
    circle_end = (pi / 4) ** 2 * mpf("1.0001")
    half = mpf("0.5000001")
    atan_end = (sqrt(mpf(2)) - 1) ** 2 * mpf("1.0001")
    return [
        ("kExp2Near", f"2^r, |r| <= 1/{2 * EXP2_ENTRIES}, but for its first coefficient, 1", lambda r: mpf(2) ** r, -exp2_end, exp2_end, 3),
        ("kLog2Near", f"log2(1 + r) / r, |r| <= 1/{2 * LOG2_ENTRIES}", log2_near, -log2_end, log2_end, 3),
        ("kLog2Nearer", "the same for pow()", log2_near, -log2_end, log2_end, 4),
        ("kSinShort", "(sin(r) / r - 1) / r^2, in r^2, |r| <= pi/4", sin_series, 0, circle_end, 3),
        ("kCosShort", "(cos(r) - 1) / r^2, in r^2, |r| <= pi/4", cos_series, 0, circle_end, 4),
        ("kAsinShort", "(asin(s) / s - 1) / s^2, in s^2, |s| <= 1/2", asin_series, 0, mpf("0.25"), 6),
        ("kAtanShort", "(atan(t) / t - 1) / t^2, in t^2, |t| <= tan(pi/8)", atan_series, 0, atan_end, 6),
        ("kExp2Long", "(2^r - 1 - r log(2)) / r^2, |r| <= 1/2", exp2_tail, -half, half, 11),
        ("kExpLong", "(e^r - 1 - r) / r^2, |r| <= log(2) / 2", exp_tail, -LN2 * half, LN2 * half, 11),
        ("kLogLong", "(atanh(s) / s - 1) / s^2, in s^2", log_series, 0, log_end, 10),
        ("kLogRest", "(atanh(s) / s - 1 - s^2 / 3) / s^4, in s^2", log_rest, 0, log_end, 11),
        ("kSinLong", "as kSinShort, in r^2", sin_series, 0, circle_end, 7),
        ("kCosLong", "(cos(r) - 1 + r^2 / 2) / r^4, in r^2", cos_rest, 0, circle_end, 7),
        ("kAsinLong", "as kAsinShort, in s^2", asin_series, 0, mpf("0.25"), 14),
        ("kAtanLong", "as kAtanShort, in t^2", atan_series, 0, atan_end, 12),
    ]


def constants():
    def upper(x, bits):
        """x rounded down to so many bits."""
        exponent = mp.floor(mp.log(x, 2)) + 1
        return mp.floor(x * mpf(2) ** (bits - exponent)) / mpf(2) ** (bits - exponent)

    half_pi = upper(pi / 2, 33)
    ln2 = upper(LN2, 42)
    return [
        ("kTwoOverPi", "2 / pi", 2 / pi),
        ("kHalfPiUpper", "33 bits of pi / 2, whose products with integers below 2^20 are exact", half_pi),
        ("kHalfPiLower", "the rest of it", pi / 2 - half_pi),
        ("kHalfPi", "pi / 2, nearest", pi / 2),
        ("kHalfPiRest", "the rest of it", pi / 2 - mpf(float(pi / 2))),
        ("kQuarterPi", "pi / 4, nearest", pi / 4),
        ("kQuarterPiRest", "the rest of it", pi / 4 - mpf(float(pi / 4))),
        ("kTanEighthPi", "tan(pi / 8)", sqrt(mpf(2)) - 1),
        ("kLog2E", "log2(e), nearest", 1 / LN2),
        ("kLog2ERest", "the rest of it", 1 / LN2 - mpf(float(1 / LN2))),
        ("kLn2", "log(2), nearest", LN2),
        ("kLn2Upper", "42 bits of log(2), whose products with exponents are exact", ln2),
        ("kLn2Lower", "the rest of it", LN2 - ln2),
        ("kThird", "1 / 3, nearest", mpf(1) / 3),
        ("kThirdRest", "the rest of it", mpf(1) / 3 - mpf(float(mpf(1) / 3))),
    ]


def exp2_table():
    """The bits of 2^(i / n) as double, less those of i in the place that i has in the bits of k / n."""
    bits = lambda x: struct.unpack("<Q", struct.pack("<d", float(x)))[0]
    return [(bits(mpf(2) ** (mpf(i) / EXP2_ENTRIES)) - i * 2**52 // EXP2_ENTRIES) % 2**64 for i in range(EXP2_ENTRIES)]


def log2_intervals():
    """The bits of the lowest mantissa, and (1 / c, log2(c)) of each interval: of equal length in the bits of floats; c is its middle."""
    value = lambda bits: mpf(struct.unpack("<f", struct.pack("<I", bits))[0])
    length, one = 2**23 // LOG2_ENTRIES, 0x3f800000
    # 1 is c of its own interval, so that logarithms near 0 have small relative errors. Floats below
    # 1 are twice as dense: two thirds of the interval are below, so that it ends as far above.
    lowest = one - 2 * length // 3
    entries = []
    for i in range(LOG2_ENTRIES):
        low, high = value(lowest + i * length), value(lowest + (i + 1) * length)
        inverse = mpf(1) if low < 1 < high else mpf(float(2 / (low + high)))
        if max(abs(low * inverse - 1), abs(high * inverse - 1)) > mpf(1) / (2 * LOG2_ENTRIES):
            raise ArithmeticError(f"interval {i} is too long")
        entries.append((inverse, -log(inverse) / LN2))
    return lowest, entries


def two_over_pi_words(count):
    mp.prec = 64 * (count + 4)
    scaled = int(mp.floor(2 / (+pi) * mpf(2) ** (64 * count)))
    mp.dps = 60
    return [(scaled >> (64 * (count - 1 - i))) & (2**64 - 1) for i in range(count)]


def header():
    lines = [
        "// Coefficients of the elementary functions, written by fit_elementary.py.",
        "// SPDX-License-Identifier: Apache-2.0",
        "#pragma once",
        "",
        "#include <cstdint>",
        "",
        "namespace kindling::elementary {",
        "",
    ]
    for name, what, value in constants():
        lines.append(f"inline constexpr double {name} = {float(value).hex()}; // {what}")
    lines.append("")
    for name, what, f, low, high, count in polynomials():
        exact = remez(f, low, high, count)
        rounded = [mpf(float(c)) for c in exact]
        if "but for its first coefficient" in what:
            exact, rounded[0] = exact[1:], mpf(1)
        grid = [mpf(low) + (mpf(high) - mpf(low)) * i / 400 for i in range(401)]
        error = max((x if low == 0 else 1) * abs(f(x) - horner(rounded, x)) for x in grid)
        times = {"s": " times s^2", "r": " times r^2", "t": " times t^2"}[what.split("in ")[1][0]] if "in " in what and low == 0 else ""
        lines.append(f"// {what}; error{times} {float(error):.1e}.")
        lines.append(f"inline constexpr double {name}[] = {{{', '.join(float(c).hex() for c in exact)}}};")
    lowest, entries = log2_intervals()
    lines += [
        "",
        f"// The bits of 2^(i / {EXP2_ENTRIES}) less i 2^52 / {EXP2_ENTRIES}. Adding k 2^52 / {EXP2_ENTRIES} gives those of",
        f"// 2^(k / {EXP2_ENTRIES}) for i = k mod {EXP2_ENTRIES}.",
        f"inline constexpr uint64_t kExp2Table[] = {{{', '.join(f'0x{w:016x}' for w in exp2_table())}}};",
        "",
        f"// Mantissas from that of these bits of a float to twice that are divided into {LOG2_ENTRIES} intervals.",
        f"inline constexpr uint32_t kMinMantissa = 0x{lowest:08x};",
        "// The inverse of the middle of each interval, and the logarithm of the middle.",
        "struct Log2Entry {",
        "  double inverse;",
        "  double log2;",
        "};",
        f"inline constexpr Log2Entry kLog2Table[] = {{{', '.join('{' + float(c).hex() + ', ' + float(v).hex() + '}' for c, v in entries)}}};",
    ]
    words = two_over_pi_words(20)
    lines.append("")
    lines.append("// 64 zeros and the first 1280 bits of 2 / pi.")
    lines.append(f"inline constexpr uint64_t kTwoOverPiBits[] = {{0, {', '.join(f'0x{w:016x}' for w in words)}}};")
    lines += ["", "} // namespace kindling::elementary", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    text = header()
    if sys.argv[1:] == ["--check"]:
        stored = (pathlib.Path(__file__).parent / "elementary_coefficients.h").read_text()
        # The order of words only: clang-format breaks the lines.
        if "".join(stored.split()).replace("//", "") != "".join(text.split()).replace("//", ""):
            sys.exit("fit_elementary.py: elementary_coefficients.h is not what the fit gives; write it again")
    else:
        print(text, end="")
