"""A target's rows in the tables of runtime/COST.md, which are written, and its ceilings in
budgets.toml, which are gates.

A kind of figures is a table of both: its figures are a dictionary by name, whole numbers or such
with one decimal, in the table's order.
"""
import os
import sys
import tomllib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "tools", "measure"))
import page  # noqa: E402

# How the heading of a kind's table begins in COST.md.
HEADINGS = {"text": "| core | .text: rays |", "stack": "| core | stack: open |",
            "instructions": "| core | unproject |", "points": "| target | unproject |",
            "frames": "| target | GREY8, 32 |", "conditions": "| core | .text: operating point |",
            "conditions of Linux": "| target | .text: operating point |"}


def find_row(lines, title, name):
    """Number of the line that begins with name, in the table whose heading begins with title."""
    headings = [k for k, line in enumerate(lines) if line.startswith(title)]
    if len(headings) != 1:
        sys.exit(f"COST.md has {len(headings)} tables '{title}'")
    for place in range(headings[0], len(lines)):
        if lines[place].startswith(f"| {name} |"):
            return place
        if not lines[place].startswith("|"):
            break
    return sys.exit(f"COST.md's table '{title}' has no row of {name}")


def write_rows(cost, target, kinds):
    """Replaces the target's row in the table of each kind; one cell a column."""
    with open(cost, encoding="utf-8") as file:
        lines = file.read().split("\n")
    for kind, figures in kinds.items():
        place = find_row(lines, HEADINGS[kind], target)
        row = f"| {target} | " + " | ".join(map(str, figures.values())) + " |"
        if row.count("|") != lines[place].count("|"):
            sys.exit(f"COST.md's table '{HEADINGS[kind]}' has other columns than {', '.join(figures)}")
        lines[place] = row
    with open(cost, "w", encoding="utf-8") as file:
        file.write("\n".join(lines))


def find_faults(kind, budget, target, figures):
    """The faults of a kind's figures, given the kind's table of budgets.toml.

    A figure below half of its ceiling is one, too: what should be measured did not run, or
    the ceiling no longer tells anything. Stacks differ more than that among calls of one ceiling.
    """
    if budget["figures"] != list(figures) or len(budget.get(target, ())) != len(figures):
        return ["budgets.toml has other figures than " + ", ".join(figures)]
    faults = []
    for (name, figure), ceiling in zip(figures.items(), budget[target]):
        if figure > ceiling:
            faults.append(f"{name} takes {figure}, its ceiling is {ceiling}")
        elif figure <= 0 or (figure < ceiling / 2 and kind != "stack"):
            faults.append(f"{name} takes {figure}, less than half of its ceiling {ceiling}")
    return faults


def check_budgets(path, target, kinds):
    """Exits where a figure lies above its ceiling."""
    with open(path, "rb") as file:
        budgets = tomllib.load(file)
    faults = [f"{kind}: {fault}" for kind, figures in kinds.items()
              for fault in find_faults(kind, budgets[kind], target, figures)]
    if faults:
        sys.exit(f"{target}: " + "; ".join(faults) + f"; ceilings stand in {path}")


def add_arguments(parser):
    parser.add_argument("--budgets", required=True, help="budgets.toml")
    parser.add_argument("--update", metavar="COST.md",
                        help="write the figures into this file instead of comparing them")


def settle(arguments, target, kinds):
    """Writes the figures of each kind, also into the benchmarks' page, or compares them with their ceilings."""
    if arguments.update:
        write_rows(arguments.update, target, kinds)
        page.update()
    else:
        check_budgets(arguments.budgets, target, kinds)
