#!/usr/bin/env python3
"""Finds calls of the C library's elementary functions in the libraries that decide pixels.

usage: check_math_symbols.py NM LIST
NM is the program that lists symbols, LIST a file with one line for each library: target; path of its archive. The
results of these functions differ between versions of the C library, and so would images: renderer/base/elementary.h
has the ones to use. math_symbols.toml has the exceptions with their reasons."""
# SPDX-License-Identifier: Apache-2.0
import pathlib
import re
import subprocess
import sys
import tomllib

FUNCTIONS = ["acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "cos", "cosh", "erf", "erfc", "exp", "exp10", "exp2", "expm1",
             "fma", "hypot", "lgamma", "log", "log10", "log1p", "log2", "pow", "sin", "sincos", "sinh", "tan", "tanh", "tgamma", "j0", "j1", "y0", "y1"]
# With the types float and long double, and the names that -ffast-math and vector code call.
PATTERN = re.compile(rf"(?:__)?(?:{'|'.join(FUNCTIONS)})[fl]?(?:_r)?(?:_finite)?|_ZGV\w+_(?:{'|'.join(FUNCTIONS)})[fl]?")


def functions_in(listing):
    """The elementary functions among the undefined symbols that `nm -u` prints."""
    symbols = (line.split()[-1].split("@")[0] for line in listing.splitlines() if line.strip().startswith("U "))
    return sorted({symbol for symbol in symbols if PATTERN.fullmatch(symbol)})


def findings(found, exceptions):
    """Messages about functions in {target: functions} that have no exception, and about exceptions without a use."""
    for target, functions in found.items():
        allowed = exceptions.get(target, {}).get("functions", [])
        for function in functions:
            if function not in allowed:
                yield f"{target} calls {function}() of the C library; use renderer/base/elementary.h, or add a reason to math_symbols.toml"
        for function in allowed:
            if function not in functions:
                yield f"math_symbols.toml: {target} does not call {function}(); remove it"


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    table = tomllib.loads((pathlib.Path(__file__).parent / "math_symbols.toml").read_text(encoding="utf-8"))
    found = {}
    for line in pathlib.Path(sys.argv[2]).read_text(encoding="utf-8").splitlines():
        target, archive = line.split("; ")
        if pathlib.Path(archive).exists():  # else not built
            found[target] = functions_in(subprocess.run([sys.argv[1], "-u", archive], check=True, capture_output=True, text=True).stdout)
    if not found:
        sys.exit("check_math_symbols.py: none of the libraries is built")
    messages = list(findings(found, table))
    print("\n".join(messages) or f"{len(found)} libraries call no elementary function but the exceptions")
    sys.exit(1 if messages else 0)


if __name__ == "__main__":
    main()
