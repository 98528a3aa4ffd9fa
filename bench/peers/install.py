#!/usr/bin/env python3
"""Installs the renderers that Kindling is raced against, in a Python environment of their own.

    bench/peers/install.py [NAME...]      # cycles, mitsuba, mitsuba_cuda, luxcore; without a name all

The environment is $XDG_CACHE_HOME/kindling/peers (~/.cache without the variable); removing the folder removes them. A renderer
that the running Python has in the same version is used from there.
"""
# SPDX-License-Identifier: Apache-2.0
import importlib.metadata
import os
import subprocess
import sys
from pathlib import Path

# The newest versions for Python 3.11, which Debian 12 has.
PACKAGES = {"cycles": "bpy==5.0.1", "mitsuba": "mitsuba==3.9.1", "mitsuba_cuda": "mitsuba==3.9.1", "luxcore": "pyluxcore==2.11.2"}


def environment_folder():
    cache = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(cache) / "kindling" / "peers"


def python():
    return environment_folder() / "bin" / "python"


def python_of(name):
    """The Python that has the package: the running one, or that of the environment."""
    return Path(sys.executable) if at_hand(name) else python()


def at_hand(name):
    """Whether the running Python has the package in the wanted version."""
    package, version = PACKAGES[name].split("==")
    try:
        return importlib.metadata.version(package) == version
    except importlib.metadata.PackageNotFoundError:
        return False


def installed(name):
    """Whether the package is there in the wanted version."""
    package, version = PACKAGES[name].split("==")
    return at_hand(name) or any(environment_folder().glob(f"lib/python3*/site-packages/{package}-{version}.dist-info"))


def install(names):
    """Returns those that could not be installed, each with pip's last line."""
    names = [name for name in names if not at_hand(name)]
    if names and not python().is_file():
        made = subprocess.run([sys.executable, "-m", "venv", environment_folder()], capture_output=True, text=True, check=False)
        if made.returncode != 0:
            return {name: "no environment (Debian: apt-get install python3-venv)" for name in names}
    failed = {}
    for name in names:
        if installed(name):
            continue
        print(f"installing {PACKAGES[name]} in {environment_folder()}", file=sys.stderr)
        done = subprocess.run([python(), "-m", "pip", "install", "--quiet", PACKAGES[name], "numpy<2"], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            failed[name] = (done.stderr.strip().splitlines() or ["pip failed"])[-1]
    return failed


def main():
    names = sys.argv[1:] or list(PACKAGES)
    if unknown := sorted(set(names) - set(PACKAGES)):
        sys.exit(f"install.py: no renderer {', '.join(unknown)}; there are {', '.join(PACKAGES)}")
    failed = install(names)
    for name, reason in failed.items():
        print(f"{name}: {reason}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
