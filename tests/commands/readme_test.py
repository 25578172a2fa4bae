"""README.md says what BENCHMARKS.md has, which tools/measure_readme writes. Nothing is measured here."""
import os
import re
import unittest

import command_test

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
FIGURE = re.compile(r"(\d+(?:\.\d+)?)\s(px|kB|×(?!\s*\d)|times)")


def read_text(name):
    with open(os.path.join(ROOT, name), encoding="utf-8") as file:
        return file.read()


def rows(text):
    """Cells of Markdown tables' rows."""
    return [[cell.strip() for cell in line.strip("|\n").split("|")] for line in text.splitlines()
            if line.startswith("|") and not line.startswith("|-")]


class Readme(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.benchmarks = read_text("BENCHMARKS.md")
        cls.figures = rows(cls.block("## Figures of README.md"))[1:]

    @classmethod
    def block(cls, title):
        """The text below a title, as far as the next of its rank."""
        rank = title.split()[0]
        found = re.search(rf"^{re.escape(title)}\n(.*?)(?=^#{{2,{len(rank)}}} |\Z)", cls.benchmarks,
                          re.MULTILINE | re.DOTALL)
        return found.group(1) if found else ""

    def test_figures_are_measured(self):
        told = set(FIGURE.findall(read_text("README.md")))
        measured = set(FIGURE.findall("\n".join(row[0] for row in self.figures)))
        self.assertTrue(told)
        self.assertEqual(told - measured, set(), "in README.md, and not among BENCHMARKS.md's figures of it")

    def test_figures_are_those_of_the_tables(self):
        for figure, title, *model in self.figures:
            if not figure.endswith(" px"):
                continue
            with self.subTest(figure=figure, model=model):
                medians = [row[5] for row in rows(self.block("### " + title)) if row[:3] == model]
                self.assertEqual(medians, [figure.split()[0]])

    def test_comparisons_state_both_ways(self):
        """Rigid and flexed, of raygrid and of its peers, whose imports are the same cameras."""
        sets = re.findall(r"^### (.*)$", self.block("## Rigid and flexed"), re.MULTILINE)
        self.assertIn("fisheye_190: a fisheye of 190°, board of deltilles, both ways", sets)
        for title in sets:
            head, *told = rows(self.block("### " + title))
            self.assertEqual(head[3:9], ["rigid median", "RMS", "corners", "flexed median", "RMS", "corners"])
            self.assertEqual({row[0].split()[0] for row in told}, {"raygrid", "OpenCV", "mrcal"})
            for row in told:
                with self.subTest(title=title, row=row[:3]):
                    rigid, own = float(row[3]), row[9]
                    self.assertGreater(float(row[5]), 0)
                    if row[6] != "–":  # the points of one are far off a plane
                        self.assertLess(abs(float(row[8]) - float(row[5]) / 2), 0.05 * float(row[5]))
                    self.assertEqual(own == "", row[0] == "raygrid")
                    if own:
                        self.assertAlmostEqual(rigid, float(own), delta=0.01 * rigid + 0.001)


if __name__ == "__main__":
    command_test.main(__name__)
