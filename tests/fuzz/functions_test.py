#!/usr/bin/env python3
"""Every function of the runtime is fuzzed with arguments at their limits."""
import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


class FuzzedFunctions(unittest.TestCase):
    def test_every_function_is_called(self):
        header = (ROOT / "runtime" / "raygrid.h").read_text(encoding="utf-8")
        declared = set(re.findall(r"^[a-z]\w*[\w ]* \*?(?:const )?(rg_\w+)\(", re.sub(
            r"/\*.*?\*/", "", header, flags=re.DOTALL).replace("*", " "), re.MULTILINE))
        self.assertGreater(len(declared), 30)
        called = set(re.findall(r"\b(rg_\w+)\(", (ROOT / "tests" / "fuzz" / "fuzz_arguments.c")
                                .read_text(encoding="utf-8")))
        self.assertEqual(declared - called, set())


if __name__ == "__main__":
    unittest.main()
