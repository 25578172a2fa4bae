"""Former option names are listed on a page, and the names that replace them exist."""
import importlib.machinery
import importlib.util
import re
import unittest
from functools import lru_cache
from pathlib import Path

import command_test
from command_test import run

WRITER = Path(__file__).resolve().parents[2] / "tools" / "write_renamed"


def load_writer():
    loader = importlib.machinery.SourceFileLoader("write_renamed", str(WRITER))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


@lru_cache
def options_of(command):
    return set(re.findall(r"--[a-z][\w-]*", run(command, "--help").stdout))


class RenamedOptions(unittest.TestCase):
    def test_the_page_is_current(self):
        done = run("--check", program=WRITER)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_help_has_the_current_names_alone(self):
        renamed = load_writer().renamed_options()
        self.assertGreater(len(renamed), 0)
        for command, former, current in renamed:
            with self.subTest(command=command, former=former):
                options = options_of(command or "calibrate")
                self.assertIn(current, options)
                self.assertNotIn(former, options)


if __name__ == "__main__":
    command_test.main(__name__)
