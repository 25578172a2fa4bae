"""Rows of figures in the tables of the runtime's README: written, or compared.

A figure that has grown by more than 2 % fails, and so does one that has shrunk by more than
10 %: whole numbers, or such with one decimal; None, "-" in the table, is one that there is not.
"""
import sys

GROWTH, SHRINKAGE = 1.02, 0.9


def find_row(lines, title, name):
    """Number of the line that begins with name, in the table whose heading begins with title."""
    headings = [k for k, line in enumerate(lines) if line.startswith(title)]
    if len(headings) != 1:
        sys.exit(f"the README has {len(headings)} tables '{title}'")
    for place in range(headings[0], len(lines)):
        if lines[place].startswith(f"| {name} |"):
            return place
        if not lines[place].startswith("|"):
            break
    return sys.exit(f"the README's table '{title}' has no row of {name}")


def as_text(figure):
    return "-" if figure is None else str(figure)


def is_fault(figure, cell):
    if figure is None or cell == "-":
        return as_text(figure) != cell
    limit, rounding = float(cell), 0.05 if isinstance(figure, float) else 0
    return figure > limit * GROWTH + rounding or figure < limit * SHRINKAGE - rounding


def compare(line, figures):
    """Faults of figures against a row."""
    cells = [cell.strip() for cell in line.split("|")[2:-1]]
    if len(cells) != len(figures):
        return [f"{len(figures)} figures, but the README has {len(cells)}"]
    return [f"{as_text(figure)}, but the README says {cell}"
            for figure, cell in zip(figures, cells) if is_fault(figure, cell)]


def settle(readme, name, tables, update):
    """Compares the figures of each table's title, or writes them; exits where they differ."""
    with open(readme, encoding="utf-8") as file:
        lines = file.read().split("\n")
    faults = []
    for title, figures in tables.items():
        place = find_row(lines, title, name)
        faults += compare(lines[place], figures)
        lines[place] = f"| {name} | " + " | ".join(map(as_text, figures)) + " |"
    if update:
        with open(readme, "w", encoding="utf-8") as file:
            file.write("\n".join(lines))
    elif faults:
        sys.exit(f"{name}: " + "; ".join(faults) + "; if that is as it should be, --update")
