#!/usr/bin/env python3
"""Tests of the rule of order in made-up sources."""
# SPDX-License-Identifier: Apache-2.0
import tempfile
import unittest
from pathlib import Path

import rules_order


class Order(unittest.TestCase):
    def test_finds_two_draws_in_one_call(self):
        for text in ("f(random(), random());", "V3f p(uniform(rng), 0.0f, uniform(rng, 0.0f, 1.0f));", "s(random.next_1d(), random.next_2d());",
                     "f(2 * uniform(), -uniform());", "f(g(draws.number()), {1, draws.number()});", "f(a,\n  random(),\n  random());",
                     "add(p + direction(rng) * size, p + direction(rng) * size);", "f(a.next_1d(), b.next_1d());"):
            self.assertEqual(rules_order.disordered(text), [1], text)

    def test_finds_two_draws_of_one_operator(self):
        for text in ("x = uniform(rng) - uniform(rng);", "x += a * direction(rng) * (b + uniform(rng, 0, f(1)));", "if (random() < random()) f();",
                     "return turn(rng) * scale * turn(rng);", "x = random() % 2 == 0 ? uniform(rng) * uniform(rng) : 0;"):
            self.assertEqual(rules_order.disordered(text), [1], text)

    def test_accepts_draws_in_order(self):
        for text in ("V3f p{random(), random(), random()};", "f({random(), random()});", "const float a = random(), b = random();",
                     "x = random() < 0.5f ? 0.0f : random();", "if (random() < 0.5f) x = random();", "for (int i = random(); i < 3; i += random()) f(random());",
                     "if (random() > 1 && random() > 2) f();", "f(random()); g(random());", "// f(random(), random())", "soup(rng, count, uniform(rng));",
                     "sort(numbers.begin(), numbers.end());", "f(a, random());", "while (random() < 3) f(random());"):
            self.assertEqual(rules_order.disordered(text), [], text)

    def test_names_the_line(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "tests" / "a" / "b.cpp"
            path.parent.mkdir(parents=True)
            path.write_text("int a;\nint b = f(random(), random());\n", encoding="utf-8")
            found = list(rules_order.check_order(Path(folder), None))
            self.assertEqual(len(found), 1, found)
            self.assertIn("tests/a/b.cpp:2: two random draws", found[0])


if __name__ == "__main__":
    unittest.main()
