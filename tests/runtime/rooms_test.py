"""The rooms of runtime/ include what their READMEs say, and no file includes itself by way of
others."""
import re
import unittest
from pathlib import Path

RUNTIME = Path(__file__).resolve().parents[2] / "runtime"
# The rooms that files of a room may include.
KNOWS = {
    "rays": set(),
    "frames": {"kernels", "cortex_m"},
    "kernels": set(),
    "cortex_m": {"kernels"},
}


def core_files():
    """The files of the rooms and beside raygrid.h, with their names in runtime/."""
    paths = [*RUNTIME.glob("*.h"), *(path for room in KNOWS for path in (RUNTIME / room).glob("*.[ch]"))]
    return {str(path.relative_to(RUNTIME)): path.read_text(encoding="utf-8") for path in sorted(paths)}


def includes(text):
    return re.findall(r'^#include "([\w/]+\.h)"', text, re.MULTILINE)


class Rooms(unittest.TestCase):
    def setUp(self):
        self.files = core_files()
        self.assertGreater(len(self.files), 50)

    def test_files_include_what_their_room_may(self):
        for name, text in self.files.items():
            room = name.split("/")[0]
            others = {path.split("/")[0] for path in includes(text) if "/" in path} - {room}
            with self.subTest(name):
                self.assertLessEqual(others, KNOWS.get(room, set()))

    def test_no_file_knows_itself_by_way_of_others(self):
        """A header and the source of its name are one."""
        def unit(name):
            return re.sub(r"\.[ch]$", "", name)
        knows = {}
        for name, text in self.files.items():
            knows.setdefault(unit(name), set()).update(unit(path) for path in includes(text))

        def visit(name, path):
            self.assertNotIn(name, path, " -> ".join([*path, name]))
            for other in knows.get(name, set()) - {name}:
                visit(other, [*path, name])
        for name in knows:
            visit(name, [])

    def test_every_file_is_in_the_readme_of_its_room(self):
        for room in KNOWS:
            text = (RUNTIME / room / "README.md").read_text(encoding="utf-8")
            for path in (RUNTIME / room).glob("*.[ch]"):
                self.assertIn(f"`{path.name}`", text, room)


if __name__ == "__main__":
    unittest.main()
