#!/usr/bin/env python3
"""Tests of the rules of language: a good and a broken case of each."""
# SPDX-License-Identifier: Apache-2.0
import tempfile
import unittest
from pathlib import Path

import house_sources
import rules_language

TABLE = {
    "width": 60,
    "beginnings": ["of", "what", "whether"],
    "words": [{"find": ["pictures?"], "use": "image"}, {"find": ["stands? still", "is told"], "use": "static, reported"},
              {"find": ["colou?r(?<!color)"], "use": "color"}, {"find": ["least"], "use": "min", "in": ["names"]}],
    "test_names": {"beginnings": ["what"], "anywhere": ["told", "goes on"]},
    "allow": [{"file": "renderer/webp.cpp", "words": ["WebPPicture"], "reason": "libwebp's"},
              {"file": "renderer/gone.cpp", "words": ["is told"], "reason": "none any more"},
              {"rule": "test_names", "file": "tests/quoted_test.cpp", "words": ["Told"], "reason": "quoted"}],
}
HEAD = "// A file.\n// SPDX-License-Identifier: Apache-2.0\n"


class RuleTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = Path(self.folder.name)
        self.language = rules_language.Language(TABLE)

    def findings(self, check, path, text):
        (self.root / path).parent.mkdir(parents=True, exist_ok=True)
        (self.root / path).write_text(text, encoding="utf-8")
        found = list(check(self.root, None, self.language))
        (self.root / path).unlink()
        return found

    def expect(self, check, path, text, *places):
        """One finding for each place, which is a line number and a word of the message."""
        found = self.findings(check, path, text)
        self.assertEqual(len(found), len(places), found)
        for line, (number, word) in zip(found, places):
            self.assertIn(f"{path}:{number}:", line)
            self.assertIn(word, line)


class Words(RuleTest):
    def test_accepts_good_sources(self):
        for path, text in (("renderer/a.h", HEAD + "int least_squares_of_film; // pictured, at least\n"), ("bench/a.py", '"""A file."""\nimage = "color"\n'),
                           ("renderer/README.md", "An image is colored. See https://example.org/picture\n")):
            self.language.names = self.language.names[:3] if path.endswith(".h") else self.language.names
            self.expect(rules_language.check_words, path, text)

    def test_finds_words_in_comments_and_literals(self):
        self.expect(rules_language.check_words, "renderer/a.cpp", HEAD + "int a; // a Picture\nauto b = \"the pictures\";\nauto c = R\"(colour)\";\n",
                    (3, "Picture"), (4, "pictures"), (5, "colour"))

    def test_finds_phrases_across_lines(self):
        self.expect(rules_language.check_words, "renderer/a.cpp", HEAD + "// What stands\n// still.\nint a;\n", (3, "stands still"))
        self.expect(rules_language.check_words, "renderer/a.cpp", HEAD + 'auto a = "it is "\n         "told";\n', (3, "is told"))

    def test_phrases_end_at_code(self):
        self.expect(rules_language.check_words, "renderer/a.cpp", HEAD + "// stands\nint a; // still\n")

    def test_finds_names_once(self):
        self.expect(rules_language.check_words, "renderer/a.cpp", HEAD + "int kLeastSize, picture_px;\nint b = kLeastSize;\n", (3, "kLeastSize"), (3, "picture_px"))

    def test_finds_file_names(self):
        self.expect(rules_language.check_words, "renderer/picture_size.h", HEAD, (1, "file's name"))

    def test_leaves_test_names_to_their_rule(self):
        self.expect(rules_language.check_words, "tests/a_test.cpp", HEAD + "TEST(Film, LeastIsZero) {}\n")

    def test_reads_python_markdown_and_cmake(self):
        self.expect(rules_language.check_words, "bench/a.py", '"""A picture."""\n# it is told\nleast = "colour"\n', (1, "picture"), (2, "is told"), (3, "least"), (3, "colour"))
        self.expect(rules_language.check_words, "renderer/README.md", "It stands\nstill.\n", (1, "stands still"))
        self.expect(rules_language.check_words, "cmake/CMakeLists.txt", "# A picture.\nset(LEAST 1) # colour\n", (1, "picture"), (2, "LEAST"), (2, "colour"))

    def test_reads_formatted_literals_as_prose(self):
        self.expect(rules_language.check_words, "bench/a.py", '"""Ranks."""\nrank = f"at least {max(1, f\'{2}\')} colour" + least\n', (2, "colour"), (2, "least"))

    def test_allowed_words(self):
        self.expect(rules_language.check_words, "renderer/webp.cpp", HEAD + "WebPPicture image; // a picture\n", (3, "picture"))

    def test_reports_stale_allowances(self):
        found = self.findings(rules_language.check_words, "renderer/gone.cpp", HEAD)
        self.assertEqual(len(found), 1)
        self.assertIn("does not use any more", found[0])


class Heads(RuleTest):
    def test_accepts_good_heads(self):
        for path, text in (("renderer/a.h", HEAD + "// Returns the sum.\nint sum();\nfloat width; // of the sensor\n"), ("renderer/a.cpp", HEAD + "// Whether inner comments pass.\n"),
                           ("bench/a.py", '#!/usr/bin/env python3\n"""Measures.\n\nMore.\n"""\n'), ("cmake/a.sh", "#!/bin/sh\n# Builds.\n"), ("accel/CMakeLists.txt", "add_library(a)\n")):
            self.expect(rules_language.check_heads, path, text)

    def test_finds_bad_first_sentences(self):
        self.expect(rules_language.check_heads, "renderer/a.cpp", "// What is here.\n", (1, "begins with 'What'"))
        self.expect(rules_language.check_heads, "renderer/a.cpp", "// A file that has\n// much.\n", (1, "period"))
        self.expect(rules_language.check_heads, "renderer/a.cpp", f"// A {'very ' * 12}long file.\n", (1, "columns"))
        self.expect(rules_language.check_heads, "renderer/a.cpp", "int a;\n", (1, "no sentence"))
        self.expect(rules_language.check_heads, "bench/a.py", '"""Whether it works."""\n', (1, "begins with 'Whether'"))

    def test_finds_bad_comments_of_headers(self):
        self.expect(rules_language.check_heads, "renderer/a.h", HEAD + "#pragma once\n// Of a node,\n// what it has.\nint a;\n\n// Good.\n//\n// Whether not.\nint b; // What it is\n",
                    (4, "'Of'"), (10, "'Whether'"), (11, "'What'"))


class Width(RuleTest):
    def test_accepts_short_comments_and_addresses(self):
        self.expect(rules_language.check_width, "renderer/a.cpp", HEAD + f"// https://{'a' * 60}\nint a; // {'b ' * 40}\n")

    def test_finds_long_comments(self):
        for path, mark in (("renderer/a.cpp", "  //"), ("bench/a.py", "#"), ("cmake/a.cmake", "#")):
            self.expect(rules_language.check_width, path, f"\n{mark} {'b ' * 40}\n", (2, "columns"))

    def test_ignores_marks_in_literals(self):
        self.expect(rules_language.check_width, "renderer/a.cpp", f'auto a = R"(\n// {"b " * 40}\n)";\n')
        self.expect(rules_language.check_width, "bench/a.py", f'a = """\n# {"b " * 40}\n"""\n')


class TestNames(RuleTest):
    def test_accepts_good_names(self):
        self.expect(rules_language.check_test_names, "tests/a_test.cpp", "TEST(Film, SumsAreExact) {}\nTEST_F(FilmTest, RefusesNan) {}\n")
        self.expect(rules_language.check_test_names, "tests/a.py", "def test_sums_are_exact(self):\n    pass\n")

    def test_finds_bad_names(self):
        self.expect(rules_language.check_test_names, "tests/a_test.cpp", "TEST(Film, sums_are_exact) {}\nTEST_P(Film, WhatIsLost) {}\nTEST(Film, ErrorIsTold) {}\n",
                    (1, "CamelCase"), (2, "begins with 'what'"), (3, "says 'told'"))
        self.expect(rules_language.check_test_names, "tests/a.py", "def test_a_render_goes_on(self):\n    pass\n", (1, "says 'goes on'"))

    def test_allowed_names(self):
        self.expect(rules_language.check_test_names, "tests/quoted_test.cpp", "TEST(Film, Told) {}\n")


class Sources(unittest.TestCase):
    def test_code_and_prose_keep_places(self):
        text = 'int a = 1\'000; // it\'s\nchar b = \'"\', *c = "x // y", *d = R"z(" // )z"; /* e\nf */ g\n'
        code, prose = house_sources.split_cpp(text)
        self.assertEqual(len(code), len(text))
        self.assertEqual(len(prose), len(text))
        self.assertEqual(code.split(), "int a = 1'000; char b = , *c = , *d = ; g".split())
        self.assertEqual(prose.replace("\x01", " ").split(), ["it's", "x", "//", "y", 'z("', "//", ")z", "e", "f"])

    def test_names_are_split(self):
        for name, words in (("kMaxSizePx", "max size px"), ("max_size_px", "max size px"), ("HTMLPage2", "html page 2"), ("keys", "keys")):
            self.assertEqual(house_sources.split_name(name), words)


class ShippedTable(unittest.TestCase):
    def test_is_well_formed(self):
        language = rules_language.Language()
        self.assertGreater(len(language.phrases) + len(language.single_words), 20)
        for entry in language.allowed:
            self.assertTrue(entry["reason"] and entry["words"] and entry["file"])

    def test_good_words_pass(self):
        language = rules_language.Language()
        good = "images of colored spheres in the center; at least one neighbor, at most two; rise, otherwise, noise, precise, likely, promise, exercise, analyses"
        self.assertEqual(list(language.in_prose(good)), [])
        for name in ("kMaxSize", "at_most", "least_squares", "noise", "parse", "say"):
            self.assertIsNone(language.use_for_name(name), name)

    def test_bad_words_fail(self):
        language = rules_language.Language()
        for bad in ("colours", "normalised", "rasterisers", "a picture", "it stands still", "is told", "goes on", "of no use", "who finds no tile", "what lasts", "foreseen", "neighbouring"):
            self.assertTrue(list(language.in_prose(bad)), bad)
        for name in ("kMost", "kLeastSize", "tell_plan", "lasting_meshes", "kept_trees", "go_on", "centre"):
            self.assertIsNotNone(language.use_for_name(name), name)


if __name__ == "__main__":
    unittest.main()
