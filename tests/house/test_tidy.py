#!/usr/bin/env python3
"""Tests of tidy.py: its choice of sources, and its handling of findings and errors."""
# SPDX-License-Identifier: Apache-2.0
import contextlib
import io
import json
import subprocess
import tempfile
import unittest
from pathlib import Path

import tidy

PROGRAM = """#!/bin/sh
for source; do :; done
grep -q BAD "$source" && { echo "$source:1:1: error: bad [bugprone-bad]"; exit 1; }
exit 0
"""


class Tidy(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = Path(self.folder.name).resolve()
        for name in ("a", "b", "c", "d"):
            self.write(f"renderer/{name}.cpp", f'#include "renderer/{name}.h"\n')
        self.write("renderer/d.cpp", '#include "renderer/only.h"\n')
        self.write("renderer/big_tables.cpp", "")
        self.sources = {f"renderer/{name}.cpp" for name in ("a", "b", "c", "d", "big_tables")}
        commands = [{"file": str(self.root / source), "directory": ".", "command": ""} for source in sorted(self.sources)]
        self.write("build/alone/compile_commands.json", json.dumps([*commands, {"file": str(self.root / "build/alone/made.cpp"), "directory": ".", "command": ""}]))
        self.write("tidy.sh", PROGRAM)
        (self.root / "tidy.sh").chmod(0o755)

    def write(self, path, text):
        (self.root / path).parent.mkdir(parents=True, exist_ok=True)
        (self.root / path).write_text(text, encoding="utf-8")

    def run_tool(self, *words):
        output, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
            code = tidy.main([str(self.root / "build/alone"), "--root", str(self.root), "--program", str(self.root / "tidy.sh"), *words])
        return code, output.getvalue(), errors.getvalue()

    def test_headers_are_checked_by_a_source(self):
        self.assertEqual(tidy.source_for("renderer/a.h", self.sources, self.root), "renderer/a.cpp")
        self.assertEqual(tidy.source_for("renderer/only.h", self.sources, self.root), "renderer/d.cpp")
        for path in ("renderer/unused.h", "README.md", "renderer/gone.cpp"):
            self.assertIsNone(tidy.source_for(path, self.sources, self.root))

    def test_shares_cover_all_sources_once(self):
        shares = [tidy.choose([], [], (k, 3), self.sources, self.root) for k in (1, 2, 3)]
        self.assertEqual(sorted(sum(shares, [])), sorted(self.sources - {"renderer/big_tables.cpp"}))

    def test_changed_files_come_first(self):
        chosen = tidy.choose(["renderer/c.cpp"], ["renderer/b.h", "README.md"], (1, 1), self.sources, self.root)
        self.assertEqual(chosen[:2], ["renderer/c.cpp", "renderer/b.cpp"])
        self.assertEqual(len(chosen), 4)

    def test_clean_sources_pass(self):
        code, output, _ = self.run_tool()
        self.assertEqual(code, 0)
        self.assertIn("4 sources checked, 0 with findings", output)

    def test_findings_fail(self):
        self.write("renderer/b.cpp", "BAD\n")
        code, output, errors = self.run_tool("renderer/a.cpp", "renderer/b.cpp")
        self.assertEqual(code, 1)
        self.assertIn("2 sources checked, 1 with findings", output)
        self.assertIn("bugprone-bad", errors)

    def test_stops_after_the_limit(self):
        code, output, _ = self.run_tool("--seconds", "-1")
        self.assertEqual(code, 0)
        self.assertIn("0 sources checked, 0 with findings, 4 left out", output)

    def test_changes_since_a_commit(self):
        git = lambda *words: subprocess.run(["git", "-C", self.root, "-c", "user.name=a", "-c", "user.email=a@b", *words], check=True, capture_output=True)
        git("init", "-q")
        git("add", "renderer")
        git("commit", "-qm", "first")
        self.write("renderer/b.cpp", "BAD\n")
        code, output, _ = self.run_tool("--since", "HEAD")
        self.assertEqual(code, 1)
        self.assertIn("1 sources checked, 1 with findings", output)
        code, output, errors = self.run_tool("--since", "0123456")
        self.assertEqual(code, 0)
        self.assertIn("not known", errors)

    def test_usage_errors(self):
        for words in (["--share", "4/3"], ["--share", "x"]):
            with self.assertRaises(SystemExit) as raised, contextlib.redirect_stderr(io.StringIO()):
                tidy.main([str(self.root / "build/alone"), *words])
            self.assertEqual(raised.exception.code, 2)
        with self.assertRaises(SystemExit), contextlib.redirect_stderr(io.StringIO()):
            tidy.main([str(self.root)])


if __name__ == "__main__":
    unittest.main()
