#!/usr/bin/env python3
"""Tests of reflow_comments.py: long paragraphs are wrapped, and everything else stays as it is."""
# SPDX-License-Identifier: Apache-2.0
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import reflow_comments

TOOL = Path(__file__).resolve().parent / "reflow_comments.py"


class Reflow(unittest.TestCase):
    def reflow(self, *lines, path="a.cpp", width=30, everything=False):
        text = "\n".join(lines) + "\n"
        result = reflow_comments.reflow(path, text, width, everything)
        self.assertEqual(reflow_comments.reflow(path, result, width, everything), result)  # once is enough
        return result.split("\n")[:-1]

    def expect_same(self, *lines, **options):
        self.assertEqual(self.reflow(*lines, **options), list(lines))

    def test_wraps_long_paragraphs(self):
        self.assertEqual(self.reflow("int a;", "  // one two three four five six seven", "  // eight", "int b;"),
                         ["int a;", "  // one two three four five", "  // six seven eight", "int b;"])

    def test_leaves_short_paragraphs(self):
        lines = ["int a;", "// one", "// two", "//", "// three"]
        self.expect_same(*lines)
        self.assertEqual(self.reflow(*lines, everything=True), ["int a;", "// one two", "//", "// three"])

    def test_paragraphs_and_indentations_stay_apart(self):
        self.assertEqual(self.reflow("int a;", "// one two three four five six seven", "//", "// eight", "  // nine"),
                         ["int a;", "// one two three four five six", "// seven", "//", "// eight", "  // nine"])

    def test_first_line_stays_alone(self):
        self.assertEqual(self.reflow("// A file.", "// one two three four five six seven"), ["// A file.", "// one two three four five six", "// seven"])

    def test_lists_hang(self):
        self.assertEqual(self.reflow("int a;", "// Two:", "//  - one two three four five six", "//    seven", "// 1. eight"),
                         ["int a;", "// Two:", "//  - one two three four five", "//    six seven", "// 1. eight"])

    def test_terms_hang(self):
        self.assertEqual(self.reflow("int a;", "//   one    two three four five six", "//          seven"),
                         ["int a;", "//   one    two three four", "//          five six seven"])

    def test_no_line_begins_like_an_item(self):
        self.assertEqual(self.reflow("int a;", "// one two three four x = five - 6 seven"), ["int a;", "// one two three four x =", "// five - 6 seven"])

    def test_leaves_tables_code_and_marks(self):
        self.expect_same("int a;", "// | one | two three four five six |", "//     code sample of many columns", "// SPDX-License-Identifier: Apache-2.0",
                         "// NOLINTNEXTLINE(one-two-three-four)", "// a   b   c   d   e   f   g   h   i")

    def test_cuts_lines_of_dashes(self):
        self.assertEqual(self.reflow("int a;", "// --- title " + "-" * 40)[1], ("// --- title " + "-" * 40)[:30])

    def test_leaves_code_and_literals(self):
        self.expect_same("int abcdefghijklmnopqrstuvw = 1; // one two three", 'auto a = R"(', "// one two three four five six seven", ')";')
        self.expect_same("a = '''", "# one two three four five six seven", "'''", path="a.py")

    def test_wraps_other_languages(self):
        for path in ("a.py", "CMakeLists.txt", "a.sh"):
            self.assertEqual(self.reflow("a", "# one two three four five six seven", path=path), ["a", "# one two three four five six", "# seven"])

    def test_program(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.h"
            path.write_text("// A file.\n// " + "word " * 30 + "\n", encoding="utf-8")
            run = lambda *words: subprocess.run([sys.executable, TOOL, *words, path], capture_output=True, text=True, check=False)
            self.assertEqual(run("--check").returncode, 1)
            self.assertEqual(run().stdout, f"{path}\n")
            self.assertEqual(run("--check").returncode, 0)
            self.assertLessEqual(max(map(len, path.read_text(encoding="utf-8").splitlines())), 100)
            self.assertEqual(run("--width", "5").returncode, 2)


if __name__ == "__main__":
    unittest.main()
