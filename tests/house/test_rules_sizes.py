#!/usr/bin/env python3
"""Tests of the rules of size: files, lines, functions and branches in made-up sources."""
# SPDX-License-Identifier: Apache-2.0
import tempfile
import unittest
from pathlib import Path

import rules_sizes

TABLE = {"folder_files": 2, "file_lines": 10, "function_lines": 4, "function_complexity": 3,
         "long_files": {"renderer/a/listed.cpp": "reason", "renderer/b/short.cpp": "reason"},
         "long_functions": {"renderer/a.cpp:listed": "reason", "renderer/a.cpp:gone": "reason"}}


class Sizes(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = Path(self.folder.name)
        self.sizes = rules_sizes.Sizes(TABLE)

    def write(self, path, text):
        (self.root / path).parent.mkdir(parents=True, exist_ok=True)
        (self.root / path).write_text(text, encoding="utf-8")

    def test_accepts_small_folders_and_files(self):
        self.write("renderer/a/one.cpp", "x\n" * 10)
        self.write("renderer/a/data_tables.cpp", "x\n" * 1000)
        self.write("renderer/a/README.md", "x\n" * 1000)
        self.assertEqual(list(rules_sizes.check_sizes(self.root, None, self.sizes)), [])

    def test_finds_large_folders_and_files(self):
        for name in ("a.h", "a.cpp", "b.cpp"):
            self.write(f"tests/a/{name}", "x\n")
        self.write("renderer/a/long.cpp", "x\n" * 11)
        self.write("renderer/a/listed.cpp", "x\n" * 11)
        self.write("renderer/b/short.cpp", "x\n")
        found = list(rules_sizes.check_sizes(self.root, None, self.sizes))
        self.assertEqual(len(found), 3, found)
        self.assertIn("renderer/a/long.cpp: 11 lines", found[0])
        self.assertIn("need not list", found[1])
        self.assertIn("tests/a: 3 sources", found[2])

    def test_finds_long_and_branching_functions(self):
        self.write("renderer/a.cpp", "void good() {\n}\nvoid long_one() {\n\n\n\n}\nvoid listed() {\n\n\n\n}\nvoid branches() { if (a && b || c) d(); }\n")
        found = list(rules_sizes.check_functions(self.root, None, self.sizes))
        self.assertEqual(len(found), 3, found)
        self.assertIn("renderer/a.cpp:3: long_one has 5 lines", found[0])
        self.assertIn("renderer/a.cpp:13: branches has 1 lines (at most 4) and a complexity of 4", found[1])
        self.assertIn("renderer/a.cpp:gone", found[2])

    def test_reports_sources_without_balance(self):
        self.write("renderer/a.cpp", "void f() {\n")
        found = list(rules_sizes.check_functions(self.root, None, self.sizes))
        self.assertIn("cannot be found", found[0])


class Functions(unittest.TestCase):
    def names(self, text):
        return [function.name for function in rules_sizes.functions(text)]

    def test_finds_every_form(self):
        for text, name in (("int f(int a) { return a; }", "f"), ("auto A::f() const noexcept -> int { }", "A::f"), ("A::A(int a) : a_(a), b_{a} {}", "A::A"),
                           ("A::~A() {}", "A::~A"), ("bool operator==(const A& a, const A& b) { }", "operator=="), ("A& operator=(A&& a) noexcept { }", "operator="),
                           ("template <class T>\nrequires std::integral<T>\nvoid f(T t) { }", "f"), ("TEST(Film, Sums) {\n}", "Film.Sums"),
                           ("[[nodiscard]] int f(std::vector<int> a = {1, 2}) { }", "f"), ("namespace a::b { struct C { int f() { } }; }", "f"),
                           ("class A : public B {\n public:\n  explicit A(int a) : B(a) { }\n};", "A"), ("constexpr auto f = [](int a) { return a; };", "lambda")):
            self.assertEqual(self.names(text), [name], text)

    def test_passes_over_other_braces(self):
        for text in ("int a[] = {1, 2};", "enum class A : int { b, c };", "struct A { int b{1}; };", "namespace { int a; }", "const std::map<int, int> a{{1, 2}, {3, 4}};",
                     'const char* a = "void f() {";', "// void f() {", "#define F(a) void f() {", "extern \"C\" { int a; }"):
            self.assertEqual(self.names(text), [], text)

    def test_lambdas_count_with_their_function(self):
        found = list(rules_sizes.functions("void f() {\n  auto g = [](int a) { if (a) return 1; return 2; };\n  while (g(1)) {}\n}\nvoid h() {}\n"))
        self.assertEqual([(f.name, f.first, f.last, f.complexity) for f in found], [("f", 1, 4, 3), ("h", 5, 5, 1)])

    def test_comments_and_literals_do_not_count(self):
        found = list(rules_sizes.functions("void f() { // if for while\n  g(\"a ? b && c\", 'x', 1'000); /* case */ }\n"))
        self.assertEqual(found[0].complexity, 1)

    def test_shipped_table_is_well_formed(self):
        sizes = rules_sizes.Sizes()
        for table in (sizes.long_files, sizes.long_functions):
            for key, reason in table.items():
                self.assertTrue(reason, key)


if __name__ == "__main__":
    unittest.main()
