"""Settings of Kindling that a benchmark compares: names, and flags of `kindling render`."""
# SPDX-License-Identifier: Apache-2.0
import argparse
import re
import shlex
from dataclasses import dataclass

from peers import install as peer_packages


@dataclass
class Setting:
    name: str
    flags: list  # of `kindling render`; unused for other renderers


def parse_setting(text):
    """Reads NAME=FLAGS, for argparse."""
    match = re.fullmatch(r"([A-Za-z0-9_.+-]+)=(.*)", text, re.S)
    if not match or match[1] in peer_packages.PACKAGES:
        raise argparse.ArgumentTypeError(f"'{text}' is not NAME=FLAGS, with a NAME of letters, digits and _ . + - that is no other renderer")
    return Setting(match[1], shlex.split(match[2]))


def check_names(parser, settings):
    """Ends the program by `parser` if two settings have one name."""
    names = [setting.name for setting in settings]
    if len(set(names)) < len(names):
        parser.error(f"--setting: two are called {next(name for name in names if names.count(name) > 1)}")
