#!/usr/bin/env python3
"""Tests of check_house.py: each rule passes on a small made-up tree and finds a fault in it."""
# SPDX-License-Identifier: Apache-2.0
import tempfile
import unittest
from pathlib import Path

import check_house
import rules_layers

GOOD = {
    "renderer/base/math.h": "// Vectors.\n// SPDX-License-Identifier: Apache-2.0\n#pragma once\n#include <ImathVec.h>\n",
    "renderer/film/film.h": "// The film.\n// SPDX-License-Identifier: Apache-2.0\n#pragma once\n#include \"renderer/base/math.h\"\n",
    "renderer/film/film.cpp": "// The film's sums.\n// SPDX-License-Identifier: Apache-2.0\n#include \"renderer/film/film.h\"\n"
                              "// printf( in a comment, and std::cout\nconst char* kText = \"exit(1)\"; int n = snprintf(b, 1, \"\");\n",
    "renderer/app/main.cpp": "// The program.\n// SPDX-License-Identifier: Apache-2.0\n#include <CLI/CLI.hpp>\n"
                             "#include \"renderer/film/film.h\"\nint main() { std::cout << 1; }\n",
    "accel/accelerator.h": "// The contract.\n// SPDX-License-Identifier: Apache-2.0\n#pragma once\n",
    "tests/film/film_test.cpp": "// Tests of the film.\n// SPDX-License-Identifier: Apache-2.0\nTEST(Film, SumsAreExact) {}\n",
    "renderer/base/README.md": "`math.h`", "renderer/film/README.md": "`film`", "renderer/app/README.md": "", "accel/README.md": "`accelerator.h`",
    "tests/README.md": "", "README.md": "[film](renderer/film/README.md)\n",
}
HEAD = "// A file.\n// SPDX-License-Identifier: Apache-2.0\n"


class CheckHouse(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = Path(self.folder.name)
        self.layers = rules_layers.Layers()
        for path, text in GOOD.items():
            self.write(path, text)

    def write(self, path, text):
        (self.root / path).parent.mkdir(parents=True, exist_ok=True)
        (self.root / path).write_text(text, encoding="utf-8")

    def findings(self, rule):
        return list(check_house.RULES[rule](self.root, self.layers))

    def expect_one(self, rule, *words):
        found = self.findings(rule)
        self.assertEqual(len(found), 1, found)
        for word in words:
            self.assertIn(word, found[0])

    def test_a_good_tree_passes(self):
        for rule in check_house.RULES:
            self.assertEqual(self.findings(rule), [], rule)

    def test_upward_include(self):
        self.write("renderer/base/bad.h", HEAD + "#pragma once\n#include \"renderer/film/film.h\"\n")
        self.expect_one("includes", "renderer/base/bad.h:4", "level 2")

    def test_include_of_a_neighbor(self):
        self.write("renderer/bsdf/bad.cpp", HEAD + "  #  include \"renderer/film/film.h\"\n")
        self.expect_one("includes", "renderer/bsdf/bad.cpp:3")

    def test_neighbors_are_never_a_circle(self):
        for folder, others in self.layers.neighbors.items():
            for other in others:
                self.assertFalse(self.layers.may_use(other, folder), f"{folder} and {other}")

    def test_accelerators_include_nothing_of_the_renderer(self):
        self.write("accel/embree/bad.cpp", HEAD + "#include \"renderer/base/math.h\"\n")
        self.expect_one("includes", "accel/embree/bad.cpp:3")

    def test_library_outside_its_adapter(self):
        for header in ("tiny_gltf.h", "OpenImageIO/imageio.h", "OpenColorIO/OpenColorIO.h", "embree3/rtcore.h", "draco/core/x.h",
                       "meshoptimizer.h", "CLI/CLI.hpp", "spdlog/spdlog.h"):
            self.write("renderer/world/bad.cpp", HEAD + f"#include <{header}>\n")
            self.expect_one("includes", "renderer/world/bad.cpp:3", header)

    def test_adapter_may(self):
        self.write("accel/embree/good.cpp", HEAD + "#include <embree3/rtcore.h>\n")
        self.write("renderer/import/good.cpp", HEAD + "#include <tiny_gltf.h>\n")
        self.assertEqual(self.findings("includes"), [])

    def test_header_that_does_not_exist(self):
        self.write("renderer/app/bad.cpp", HEAD + "#include \"renderer/film/gone.h\"\n")
        self.expect_one("includes", "does not exist")

    def test_include_not_spelled_from_the_root(self):
        self.write("renderer/film/bad.cpp", HEAD + "#include \"film.h\"\n")
        self.expect_one("includes", "spelled from the root")

    def test_folder_that_the_table_does_not_know(self):
        self.write("renderer/attic/bad.cpp", HEAD)
        self.expect_one("includes", "layers.toml")

    def test_printing_and_exiting(self):
        for call in ("std::cout << 1;", "std::cerr << 1;", "printf(\"\");", "std::printf(\"\");", "fprintf(stderr, \"\");",
                     "exit(1);", "std::exit(1);", "std::abort();", "puts(\"\");", "fmt::print(\"\");"):
            self.write("renderer/film/bad.cpp", HEAD + f"void f() {{ {call} }}\n")
            self.expect_one("printing", "renderer/film/bad.cpp:3")

    def test_missing_license_sentence_and_guard(self):
        self.write("renderer/film/bad.h", "int x;\n")
        self.assertEqual(len(self.findings("files")), 3)

    def test_scripts_are_executable_if_they_name_an_interpreter(self):
        self.write("bench/race.py", "#!/usr/bin/env python3\n")
        self.expect_one("files", "bench/race.py", "chmod +x")
        (self.root / "bench/race.py").chmod(0o755)
        self.assertEqual(self.findings("files"), [])
        self.write("bench/race.py", "import sys\n")
        self.expect_one("files", "bench/race.py", "does not begin with #!")

    def test_missing_readme_and_dead_link(self):
        (self.root / "renderer/film/README.md").unlink()
        found = self.findings("readmes")
        self.assertEqual(len(found), 2, found)

    def test_link_to_a_heading(self):
        self.write("tests/README.md", "# Tests\n\n## How `ctest` is run (in CI)\n\n## Twice\n\n## Twice\n")
        good = "# Kindling\n\n[a](tests/README.md#how-ctest-is-run-in-ci) [b](tests/README.md#twice-1) [c](#kindling)\n"
        self.write("README.md", good)
        self.assertEqual(self.findings("readmes"), [])
        self.write("README.md", good + "[d](tests/README.md#twice-2)\n")
        self.assertEqual(self.findings("readmes"), ["README.md: links to tests/README.md#twice-2, which is no heading there"])

    def test_header_that_no_readme_names(self):
        self.assertEqual(self.findings("readmes"), [])
        self.write("renderer/film/film_sum.h", HEAD)  # a part of whose name is there
        self.assertEqual(self.findings("readmes"), ["renderer/film/README.md: does not name film_sum.h"])

    def write_targets(self, text):
        self.write("targets.txt", text)
        return list(rules_layers.check_links(self.root, self.layers, self.root / "targets.txt"))

    def test_links(self):
        good = "renderer/base: kindling_base; Imath::Imath\nrenderer/image: kindling_image; kindling::base\n" \
               "renderer/film: kindling_film; kindling::image\nrenderer/app: kindling_app; kindling::film; kindling::base\n"
        self.assertEqual(self.write_targets(good), [])
        upward = self.write_targets(good.replace("kindling_base; ", "kindling_base; kindling::film; "))
        self.assertEqual(len(upward), 1, upward)
        unlinked = self.write_targets(good.replace("kindling_film; kindling::image", "kindling_film; Imath::Imath"))
        self.assertEqual(len(unlinked), 1, unlinked)
        self.assertIn("does not link", unlinked[0])

    def test_lists_enforced_rules(self):
        self.assertLessEqual(set(check_house.ENFORCED), set(check_house.RULES))

    def test_summary_counts_by_folder(self):
        table = check_house.summary({"words": ["renderer/film/a.h:1: x", "renderer/film/b/c.h:2: y"], "sizes": ["renderer/import: 61 sources"]})
        self.assertIn("| renderer/film | 2 |  |", table)
        self.assertIn("| renderer/import |  | 1 |", table)
        self.assertIn("| all | 2 | 1 |", table)

    def flag_findings(self, table, render_help):
        self.write("renderer/app/README.md", table)
        help_of = {"--help": "  kindling render SCENE\n  kindling farm ACTION\n", "render": render_help,
                   "farm": "  kindling farm submit SCENE\n", "farm submit": "  --parts N"}
        for command, text in help_of.items():
            self.write(f"{command}.txt", text)
        self.write("program", '#!/bin/sh\nwords=${*% --help}\ncat "$(dirname "$0")/$words.txt"\n')
        (self.root / "program").chmod(0o755)
        return list(rules_layers.check_flags(self.root, self.root / "program"))

    def test_flags(self):
        self.assertEqual(self.flag_findings("| `--spp N` | samples |\n", "  -s,--spp N  samples, not --others\n  --help"), [])
        self.assertEqual(self.flag_findings("| `--spp N`, `--parts N` | |\n", "  --spp N"), [])
        self.assertEqual(len(self.flag_findings("| `--spp N`, `--gone` | |\n", "--spp N")), 1)
        self.assertEqual(len(self.flag_findings("| `--spp N` | |\n", "  --spp N\n  --new  new")), 1)


if __name__ == "__main__":
    unittest.main()
