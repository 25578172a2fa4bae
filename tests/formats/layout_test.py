"""The offsets, types and sizes of formats/blob_layout.h are those of formats/SPEC.md."""
import re
import unittest
from pathlib import Path

FORMATS = Path(__file__).resolve().parents[2] / "formats"
SPEC = (FORMATS / "SPEC.md").read_text(encoding="utf-8")
LAYOUT = (FORMATS / "blob_layout.h").read_text(encoding="utf-8")

# What stands in SPEC.md above a table of fields: what names of them begin with, and the name of the size of all.
TABLES = {
    "## Header\n": ("RG_HEADER_", "RG_HEADER_SIZE"),
    "The **section table** follows": ("RG_ENTRY_", "RG_SECTION_ENTRY_SIZE"),
    "### Camera (": ("RG_CAMERA_", "RG_CAMERA_SIZE"),
    "### Central grid (": ("RG_GRID_", "RG_GRID_FIELDS_SIZE"),
    "### Remap (": ("RG_REMAP_", "RG_REMAP_FIELDS_SIZE"),
    "with a view followed by\n": ("RG_VIEW_", "RG_VIEW_FIELDS_SIZE"),
    "### Sensor modes (": ("RG_MODE_", "RG_MODE_SIZE"),
    "### Quality (": ("RG_QUALITY_", "RG_QUALITY_SIZE"),
    "### Line points (": ("RG_LINE_POINTS_", "RG_LINE_POINTS_FIELDS_SIZE"),
    "### Validity mask (": ("RG_MASK_", "RG_MASK_FIELDS_SIZE"),
    "### Uncertainty (": ("RG_UNCERTAINTY_", "RG_UNCERTAINTY_FIELDS_SIZE"),
    "### Inverse grid (": ("RG_INVERSE_", "RG_GRID_FIELDS_SIZE"),
    "### Capture (": ("RG_CAPTURE_", "RG_CAPTURE_SIZE"),
    "### Operating points (": ("RG_STACK_", "RG_STACK_FIELDS_SIZE"),
    "### Line delay (": ("RG_ROW_TIME_", "RG_ROW_TIME_SIZE"),
    "## Slots\n": ("RG_SLOT_", "RG_SLOT_HEADER_SIZE"),
}
# What SPEC.md says in words instead: the fields behind each other, and the size of all.
WORDS = {
    "six i32 in q29, origin a, origin b, column_step a, column_step b, row_step a, row_step b;":
        ("RG_PLANE_", "i32[2] origin, i32[2] column_step, i32[2] row_step", "RG_NARROW_PLANE_SIZE"),
    "i16 x, i16 y (residuals), with bends followed by i8 hx, hy, vx, vy;":
        ("RG_VERTEX_", "i16 x, i16 y, i8 hx, i8 hy, i8 vx, i8 vy", "RG_BENT_VERTEX_SIZE"),
    "vertices, row by row: i16 x, i16 y (residuals)": (None, "i16 x, i16 y", "RG_VERTEX_SIZE"),
    "i32 x, y, z, in q28 m": ("RG_LINE_POINT_", "i32 x, i32 y, i32 z", "RG_LINE_POINT_SIZE"),
    "control points, row by row from the top: i32 a, i32 b": (None, "i32 a, i32 b", "RG_CONTROL_POINT_SIZE"),
    "pairs of residuals i16 a, i16 b": (None, "i16 a, i16 b", "RG_NARROW_POINT_SIZE"),
    "Each sample is followed by its value: i32, q16": (None, "i32 value", "RG_KNOT_VALUE_SIZE"),
    "| 8 | u8[32] | name |": (None, "u8[32] name", "RG_TEXT_SIZE"),
}
# Central and inverse grids have the other one's fields in the same places: code serves both.
SHARED = {"X0": "A0", "Y0": "B0", "X1": "A1", "Y1": "B1", "SCALE_X": "SCALE_A", "SCALE_Y": "SCALE_B",
          "COLUMNS": "COLUMNS", "ROWS": "ROWS", "CHART": "CHART", "FRACTION_BITS": "FRACTION_BITS",
          "DATA_OFFSET": "DATA_OFFSET"}


def size_of(kind):
    bits, count = re.fullmatch(r"[iu](8|16|32)(?:\[(\d+)\])?", kind).groups()
    return int(bits) // 8 * int(count or 1)


def read_table(title):
    """Offset, type and field of each row of the first table behind the title."""
    table = re.search(r"(?:^\|.*\n)+", SPEC[SPEC.index(title):], re.MULTILINE).group()
    rows = [[cell.strip() for cell in row.split("|")[1:4]] for row in table.splitlines()]
    assert rows[0] == ["offset", "type", "field"], title
    return [(int(offset), re.sub(r" ×(\d+)$", r"[\1]", kind), field.split(":")[0])
            for offset, kind, field in rows[2:]]


def read_words(fields):
    """The same of fields behind each other."""
    rows, offset = [], 0
    for field in fields.split(", "):
        kind, name = field.split()
        rows.append((offset, kind, name))
        offset += size_of(kind)
    return rows


def expected_names(prefix, rows):
    """Offset and type by name; the first reserved field names all of a table."""
    names = {}
    for offset, kind, field in rows:
        names.setdefault(prefix + field.upper(), (offset, kind))
    return names


def end_of(rows):
    offset, kind, _ = rows[-1]
    return offset + size_of(kind)


class Layout(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        body = "".join(re.findall(r"^enum \w+ \{$(.*?)^\};$", LAYOUT, re.MULTILINE | re.DOTALL))
        cls.fields = {name: (int(offset), kind) for name, offset, kind in
                      re.findall(r"(RG_\w+) = (\d+),?\s+/\* ([iu]\d+(?:\[\d+\])?)[,:\s]", body)}
        cls.num_fields = len(re.findall(r"\bRG_\w+ =", body))
        cls.sizes = {name: int(size)
                     for name, size in re.findall(r"^#define (RG_\w+) (\d+)u\b", LAYOUT, re.MULTILINE)}
        cls.rows = {prefix: (read_table(title), size) for title, (prefix, size) in TABLES.items()}

    def test_every_field_has_its_offset_and_type(self):
        expected = {}
        for prefix, (rows, _) in self.rows.items():
            expected.update(expected_names(prefix, rows))
        for prefix, fields, _ in WORDS.values():
            if prefix:
                expected.update(expected_names(prefix, read_words(fields)))
        self.assertEqual(self.fields, expected)
        self.assertEqual(self.num_fields, len(expected), "each name has an offset and a comment with a type")

    def test_every_size_is_that_of_the_fields(self):
        expected = {size: end_of(rows) for rows, size in self.rows.values()}
        expected.update({size: end_of(read_words(fields)) for _, fields, size in WORDS.values()})
        self.assertEqual(self.sizes, expected)

    def test_tables_have_no_gaps(self):
        for prefix, (rows, _) in self.rows.items():
            ends = [offset + size_of(kind) for offset, kind, _ in rows]
            with self.subTest(prefix):
                begin = self.sizes["RG_REMAP_FIELDS_SIZE"] if prefix == "RG_VIEW_" else 0
                self.assertEqual([offset for offset, _, _ in rows], [begin, *ends[:-1]])

    def test_titles_say_the_sizes(self):
        for title, (_, size) in TABLES.items():
            found = re.search(rf"{re.escape(title)}type \d+, (?:fields of )?(\d+)(?: or \d+)? bytes", SPEC)
            if title.startswith("###"):
                self.assertEqual(int(found.group(1)), self.sizes[size], title)

    def test_spec_has_the_words(self):
        text = " ".join(SPEC.split())
        for words in WORDS:
            self.assertTrue(words in text, f"SPEC.md has no '{words}'")

    def test_both_grids_have_their_fields_in_the_same_places(self):
        for central, inverse in SHARED.items():
            self.assertEqual(self.fields[f"RG_GRID_{central}"], self.fields[f"RG_INVERSE_{inverse}"])


if __name__ == "__main__":
    unittest.main()
