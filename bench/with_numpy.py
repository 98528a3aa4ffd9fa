"""Restarts a script that needs NumPy with Debian's Python if its own has none; import it first."""
# SPDX-License-Identifier: Apache-2.0
import importlib.util
import os
import sys
from pathlib import Path

DEBIAN_PYTHON = "/usr/bin/python3"

if importlib.util.find_spec("numpy") is None:
    if Path(sys.executable).resolve() != Path(DEBIAN_PYTHON).resolve() and os.access(DEBIAN_PYTHON, os.X_OK):
        sys.stdout.flush()
        os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])
    sys.exit("NumPy is not installed (Debian: apt-get install python3-numpy)")
