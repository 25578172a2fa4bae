"""The rooms of runtime/ include what their READMEs say, and nothing else."""
import re
import unittest
from pathlib import Path

RUNTIME = Path(__file__).resolve().parents[2] / "runtime"
# Headers of other rooms that files of a room may include. Files that are named may include more.
ALLOWED = {
    "rays": set(),
    "frames": {"kernels/remap_kernels.h", "kernels/remap_dispatch.h", "kernels/grey_row.h"},
    "kernels": {"frames/pixel_formats.h", "frames/remap_table.h"},
    "cortex_m": {"frames/remap_blocks.h", "frames/remap_table.h", "kernels/grey_row.h"},
}
EXCEPTIONS = {
    "frames/remap_parts.c": {"cortex_m/grey_row_thumb2.h"},
    "kernels/avx512.c": {"frames/remap_blocks.h"},
}


def includes_of_other_rooms(path):
    found = re.findall(r'^#include "(\w+/\w+\.h)"', path.read_text(encoding="utf-8"), re.MULTILINE)
    return {name for name in found if not name.startswith(path.parent.name + "/")}


class Rooms(unittest.TestCase):
    def test_files_include_what_their_room_may(self):
        for room, allowed in ALLOWED.items():
            files = [*(RUNTIME / room).glob("*.[ch]")]
            self.assertTrue(files, room)
            for path in files:
                name = f"{room}/{path.name}"
                with self.subTest(name):
                    self.assertLessEqual(includes_of_other_rooms(path),
                                         allowed | EXCEPTIONS.get(name, set()))

    def test_every_exception_is_needed(self):
        for name, allowed in EXCEPTIONS.items():
            with self.subTest(name):
                self.assertLessEqual(allowed, includes_of_other_rooms(RUNTIME / name))

    def test_every_file_is_in_the_readme_of_its_room(self):
        for room in ALLOWED:
            text = (RUNTIME / room / "README.md").read_text(encoding="utf-8")
            for path in (RUNTIME / room).glob("*.[ch]"):
                self.assertIn(f"`{path.name}`", text, room)


if __name__ == "__main__":
    unittest.main()
