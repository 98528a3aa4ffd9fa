#!/usr/bin/env python3
"""Rewraps comment blocks whose lines are too long: // in C++, # in CMake, Python and shell.

usage: reflow_comments.py [--width N] [--all] [--check] FILE...
A block is a run of comment-only lines of one indentation. Its paragraphs are filled to N columns
(100) where one of their lines is longer, with --all always. List items and lists of terms are
wrapped with a hanging indentation, lines of dashes are cut. Blank comment lines, tables, indented
lines, code samples, license lines and marks of tools stay as they are. The first line of a file
stays a line of its own if it ends with a period.
--check writes nothing. Prints each file that changes; exit code 0, with --check 1 if any would
change, 2 on bad usage.
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import re
import sys
from pathlib import Path

from house_sources import comment_only_lines, language_of

LINE = re.compile(r"^(?P<indent>[ \t]*)(?P<mark>//[/!]?|\#)(?P<text>.*)$")
# A list item, or a term and, two spaces or more behind it, its description.
ITEM = re.compile(r"^(?P<bullet> *(?:[-*+]|\d{1,2}[.)]|[a-z]\)) +| {2,}\S+(?: \S+)* {2,})(?=\S)(?!.*\S {2,}\S)")
RULE = re.compile(r" ?(?:[-=*~_#]{3,} .* )?[-=*~_#]{4,}")  # a line of one character, with a title or without
FIXED = re.compile(r"^(?: {2,}|\t)\S|^ ?(?:SPDX-|NOLINT|clang-format|IWYU|TODO|fmt:|noqa|type:|shellcheck|!)|^ ?\| |\S {3,}\S|\S {2}\S.* {2}\S")


def fill(words, first, following, width):
    """Lines of words: `first` and `following` are their prefixes. No line begins with what would read as a list item or a table."""
    joined = []
    for word in words:
        if joined and (ITEM.match(word + " x") or word == "|"):
            joined[-1] += " " + word
        else:
            joined.append(word)
    lines, line = [], first + joined[0]
    for word in joined[1:]:
        if len(line) + 1 + len(word) > width:
            lines.append(line)
            line = following + word
        else:
            line += " " + word
    return [*lines, line]


def reflow_block(lines, width, everything, opens_file):
    """The block's lines, rewrapped. `lines`: (indent, mark, text after the mark)."""
    output, paragraph = [], []

    def flush():
        if not paragraph:
            return
        indent, mark, text = paragraph[0]
        item = ITEM.match(text)
        first = indent + mark + (item["bullet"] if item else " ")
        if everything or any(len(indent + mark + text) > width for indent, mark, text in paragraph):
            words = " ".join(text for _, _, text in paragraph)[item.end() if item else 0:].split()
            output.extend(fill(words, first, indent + mark + " " * (len(first) - len(indent + mark)), width))
        else:
            output.extend(indent + mark + text for indent, mark, text in paragraph)
        paragraph.clear()

    for number, (indent, mark, text) in enumerate(lines):
        bullet = ITEM.match(paragraph[0][2]) if paragraph else None
        hangs = bullet and re.match(r" *", text)[0] == " " * bullet.end()
        if RULE.fullmatch(text):
            flush()
            output.append((indent + mark + text)[:width])
        elif not text.strip() or FIXED.search(text) and not hangs and not ITEM.match(text):
            flush()
            output.append(indent + mark + text)
        else:
            if ITEM.match(text) or bullet and not hangs:
                flush()
            paragraph.append((indent, mark, text))
            if opens_file and number == 0 and text.rstrip().endswith("."):
                flush()
    flush()
    return output


def reflow(path, text, width=100, everything=False):
    """The text of a file with its comment blocks rewrapped."""
    only = comment_only_lines(path, text)
    lines, output, block, keys = text.split("\n"), [], [], None

    def flush(end):
        if block:
            output.extend(reflow_block(block, width, everything, end - len(block) == 1))
            block.clear()

    for number, line in enumerate(lines, 1):
        match = LINE.match(line) if number in only and not line.startswith("#!") else None
        found = (match["indent"], match["mark"]) if match else None
        if block and found != keys:
            flush(number)
        keys = found
        if match:
            block.append((match["indent"], match["mark"], match["text"]))
        else:
            output.append(line)
    flush(len(lines) + 1)
    return "\n".join(output)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE")
    parser.add_argument("--width", type=int, default=100, help="columns of a line (default: 100)")
    parser.add_argument("--all", action="store_true", help="fill all paragraphs, not those with overlong lines alone")
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 if a file would change")
    options = parser.parse_args(arguments)
    if options.width < 20:
        parser.error(f"--width {options.width}: at least 20 is needed")
    changed = False
    for path in options.files:
        if language_of(path) not in ("cpp", "python", "script"):
            parser.error(f"{path}: neither C++, CMake, Python nor a shell script")
        text = path.read_text(encoding="utf-8")
        result = reflow(path, text, options.width, options.all)
        if result != text:
            changed = True
            print(path)
            if not options.check:
                path.write_text(result, encoding="utf-8")
    return 1 if changed and options.check else 0


if __name__ == "__main__":
    sys.exit(main())
