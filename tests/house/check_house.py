#!/usr/bin/env python3
"""Checks rules of the source tree that a program can see: layers, READMEs, language, sizes.

usage: check_house.py --root REPOSITORY [--targets FILE] [--program FILE] [--rule NAME]... [--summary]
Without --rule it checks all rules that are enforced (ENFORCED below). Rules that are not enforced yet are checked by --rule NAME
or `--rule all`. Exit code 0 if nothing was found, 1 with one line for each finding, 2 on bad usage.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import sys
from collections import Counter
from pathlib import Path

import rules_language
import rules_layers
import rules_order
import rules_sizes
from rules_layers import Layers

RULES = {
    "includes": rules_layers.check_includes, "printing": rules_layers.check_printing, "files": rules_layers.check_files,
    "readmes": rules_layers.check_readmes, "words": rules_language.check_words, "heads": rules_language.check_heads,
    "width": rules_language.check_width, "test_names": rules_language.check_test_names, "sizes": rules_sizes.check_sizes,
    "functions": rules_sizes.check_functions, "order": rules_order.check_order,
}
# ctest runs these, one test each: tests/house/CMakeLists.txt asks for them by --list-enforced. A
# rule is added once it finds nothing.
ENFORCED = ["includes", "printing", "files", "readmes", "words", "heads", "width", "test_names", "sizes", "functions", "order"]


def summary(findings):
    """Markdown: the number of findings by folder (rows) and rule (columns). `findings`: {rule: [line, ...]}."""
    counts = {rule: Counter(folder_of(line) for line in lines) for rule, lines in findings.items()}
    folders = sorted(set().union(*counts.values()))
    lines = ["| folder | " + " | ".join(findings) + " |", "|---" * (len(findings) + 1) + "|"]
    for folder in folders:
        lines.append(f"| {folder} | " + " | ".join(str(counts[rule][folder] or "") for rule in findings) + " |")
    return "\n".join([*lines, "| all | " + " | ".join(str(len(found)) for found in findings.values()) + " |"])


def folder_of(finding):
    """The folder of a finding, two levels deep."""
    path = finding.split(":")[0]
    folders = path.split("/")[:-1] if "." in path.rsplit("/", 1)[-1] else path.split("/")
    return "/".join(folders[:2]) or "."


def parse_arguments(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, help="the repository")
    parser.add_argument("--targets", type=Path, help="check the links between the targets of this list")
    parser.add_argument("--program", help="check the flags in app's README against this program's --help")
    parser.add_argument("--rule", action="append", choices=[*RULES, "all"], help="check this rule alone; may be repeated")
    parser.add_argument("--summary", action="store_true", help="print the number of findings by folder and rule in place of each")
    parser.add_argument("--list-enforced", action="store_true", help="print the enforced rules, separated by semicolons, and exit")
    options = parser.parse_args(arguments)
    if not options.list_enforced and options.root is None:
        parser.error("--root is missing; it names the repository")
    if options.root and not (options.root / "renderer").is_dir():
        parser.error(f"--root {options.root}: there is no folder renderer in it")
    return options


def main(arguments=None):
    options = parse_arguments(arguments)
    if options.list_enforced:
        print(";".join(ENFORCED))
        return 0
    layers = Layers()
    rules = options.rule or ([] if options.targets or options.program else ENFORCED)
    findings = {rule: list(RULES[rule](options.root, layers)) for rule in (RULES if "all" in rules else rules)}
    if options.targets:
        findings["links"] = list(rules_layers.check_links(options.root, layers, options.targets))
    if options.program:
        findings["flags"] = list(rules_layers.check_flags(options.root, options.program))
    lines = [line for found in findings.values() for line in found]
    print("nothing found" if not lines else summary(findings) if options.summary else "\n".join(lines))
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
