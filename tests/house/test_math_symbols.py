#!/usr/bin/env python3
"""Tests of check_math_symbols.py: which symbols count, and what exceptions do."""
# SPDX-License-Identifier: Apache-2.0
import unittest

import check_math_symbols as symbols


class Symbols(unittest.TestCase):
    def test_finds_functions_of_every_type(self):
        listing = "\nunity_0_cxx.cxx.o:\n                 U expf\n                 U sincosf\n         U powl@GLIBC_2.29\n" \
                  "                 U __expf_finite\n                 U _ZGVdN8v_sinf\n"
        self.assertEqual(symbols.functions_in(listing), ["_ZGVdN8v_sinf", "__expf_finite", "expf", "powl", "sincosf"])

    def test_leaves_exact_functions_and_names_of_others(self):
        listing = " U floorf\n U sqrtf\n U fmod\n U llrint\n U ldexpf\n U _ZN8kindling3expEf\n U expand\n U login\n U costs\n T expf\n"
        self.assertEqual(symbols.functions_in(listing), [])

    def test_takes_exceptions_and_finds_stale_ones(self):
        found = {"a": ["pow"], "b": ["exp", "log"]}
        table = {"a": {"functions": ["pow", "sin"]}, "b": {"functions": ["log"]}}
        messages = list(symbols.findings(found, table))
        self.assertEqual(len(messages), 2, messages)
        self.assertIn("sin() ", messages[0].replace("sin();", "sin() "))
        self.assertIn("b calls exp()", messages[1])


if __name__ == "__main__":
    unittest.main()
