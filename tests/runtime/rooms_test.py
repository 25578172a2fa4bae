"""The rooms of runtime/ include what their READMEs say, no file includes itself by way of others,
and choices of the build stand in few places."""
import re
import unittest
from pathlib import Path

RUNTIME = Path(__file__).resolve().parents[2] / "runtime"
# The rooms that files of a room may include.
KNOWS = {
    "rays": {"cortex_m"},
    "frames": {"kernels", "cortex_m"},
    "kernels": set(),
    "cortex_m": {"kernels"},
}
# These may choose in a function's body: which instructions there are.
MAY_CHOOSE_INSIDE = re.compile(r"config\.h|fixed_point\.h|kernels/")
MAX_CHOICES_PER_1000_LINES = 10


def core_files():
    """The files of the rooms and beside raygrid.h, with their names in runtime/."""
    paths = [*RUNTIME.glob("*.h"), *(path for room in KNOWS for path in (RUNTIME / room).glob("*.[ch]"))]
    return {str(path.relative_to(RUNTIME)): path.read_text(encoding="utf-8") for path in sorted(paths)}


def includes(text):
    return re.findall(r'^#include "([\w/]+\.h)"', text, re.MULTILINE)


def choices(text):
    """Numbers of the lines of #if, #ifdef and #ifndef; guards of headers and of C++ are none."""
    return [k for k, line in enumerate(text.split("\n"))
            if re.match(r"\s*#\s*if", line) and not re.search(r"RAYGRID_\w+_H$|__cplusplus", line)]


def depths(text):
    """How many braces are open at the beginning of each line."""
    text = re.sub(r'/\*.*?\*/|"(?:\\.|[^"\\])*"',
                  lambda match: re.sub(r"[^\n]", " ", match.group()), text, flags=re.DOTALL)
    text = re.sub(r'extern\s+ {3}\s*\{', "", text)
    depth, found = 0, []
    for line in text.split("\n"):
        found.append(depth)
        depth += line.count("{") - line.count("}")
    return found


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

    def test_choices_of_the_build_stand_outside_of_functions(self):
        for name, text in self.files.items():
            if not MAY_CHOOSE_INSIDE.match(name):
                depth = depths(text)
                inside = [k + 1 for k in choices(text) if depth[k] > 0]
                self.assertEqual(inside, [], name)

    def test_choices_of_the_build_are_few(self):
        num_choices = sum(len(choices(text)) for text in self.files.values())
        num_lines = sum(text.count("\n") for text in self.files.values())
        print(f"{num_choices} in {num_lines} lines")
        self.assertLessEqual(1000 * num_choices, MAX_CHOICES_PER_1000_LINES * num_lines)


if __name__ == "__main__":
    unittest.main()
