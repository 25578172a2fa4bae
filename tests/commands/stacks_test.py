#!/usr/bin/env python3
"""What commands say and do of a blob with a stack of cameras."""
import json
import subprocess
import sys
from pathlib import Path

from command_test import CommandTest, main, programs, run, with_word, write

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "formats"), str(ROOT / "tests/golden")]
import blob_reference as reference  # noqa: E402
import make_golden  # noqa: E402

STACK_SECTION = 12
KNOTS = [value / 65536 for value in make_golden.STACK_VALUES]


class StacksTest(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.stack = make_golden.make_stack(make_golden.make_wide())
        cls.bytes = reference.serialize(cls.stack)
        cls.blob = write(cls.path("stack.raygrid"), cls.bytes)

    def test_inspect_tells_condition_and_knots(self):
        result = self.succeed("inspect", self.blob, "--json")
        facts = json.loads(result.stdout)
        self.assertEqual(facts["format_version"], "1.6")
        self.assertEqual(facts["operating_points"], {
            "quantity": "lens_position_dpt", "samples": KNOTS,
            "bytes_per_sample": len(reference.pack_knot(self.stack.stack.knots[0])) + 4})
        warm = write(self.path("warm.raygrid"), with_word(self.bytes, STACK_SECTION, 0, 3 << 16 | 2))
        self.assertIn("operating points: quantity 'sensor_temperature_c', samples -0.5, 2, 6.18837",
                      run("inspect", warm).stdout)

    def test_reference_tells_them_too(self):
        text = subprocess.run([sys.executable, "-B", programs.reference, "inspect", self.blob],
                              capture_output=True, text=True, check=True).stdout
        self.assertIn(f"stack:\n  condition: 1\n  values: {make_golden.STACK_VALUES}\n  knots: 3", text)

    def test_without_a_condition_it_is_the_reference_camera(self):
        plain = write(self.path("plain.raygrid"), reference.serialize(
            reference.dataclasses.replace(self.stack, stack=None)))
        pixels = write(self.path("pixels.csv"), b"x,y\n10,20\n160.5,120\n300,200\n")
        rays = [run("unproject", blob, "--pixels", pixels) for blob in (self.blob, plain)]
        for result in rays:
            self.assert_done(result)
        self.assertEqual(rays[0].stdout, rays[1].stdout)

    def test_nonsense_is_refused_by_name(self):
        for offset, value in ((0, 3 << 16), (0, 1 << 16 | 1), (0, 65 << 16 | 1), (8, 0x7fffffff),
                              (4, 16), (20 + 16, 0)):
            blob = write(self.path("bad.raygrid"), with_word(self.bytes, STACK_SECTION, offset, value))
            result = run("inspect", blob)
            self.assertEqual(result.returncode, 8, (offset, value))
            self.assertEqual(len(result.stderr.splitlines()), 1)


if __name__ == "__main__":
    main(__name__)
