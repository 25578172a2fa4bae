"""A target's rows in the files of runtime/cost, which are written, and its ceilings in budgets.toml,
which are gates.

A kind of figures is a table of both: its figures are a dictionary by name, whole numbers or such
with one decimal, in the table's order.
"""
import csv
import os
import sys
import tomllib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "tools", "measure"))
import page  # noqa: E402

# Files of runtime/cost by the kind of their figures.
FILES = {"text": "code", "stack": "stack", "instructions": "instructions", "points": "points_linux",
         "frames": "frames_linux", "conditions": "operating_points",
         "conditions of Linux": "operating_points_linux"}


def write_rows(folder, target, kinds):
    """Replaces the target's row in the file of each kind; one cell a column."""
    for kind, figures in kinds.items():
        path = os.path.join(folder, FILES[kind] + ".csv")
        with open(path, encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
        if target not in [row[0] for row in rows]:
            sys.exit(f"{path} has no row of {target}")
        if len(rows[0]) != 1 + len(figures):
            sys.exit(f"{path} has other columns than {', '.join(figures)}")
        rows = [[target, *figures.values()] if row[0] == target else row for row in rows]
        with open(path, "w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(rows)


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
    parser.add_argument("--update", metavar="FOLDER",
                        help="write the figures into the files of this folder instead of comparing them")


def settle(arguments, target, kinds):
    """Writes the figures of each kind, also into the benchmarks' page, or compares them with their ceilings."""
    if arguments.update:
        write_rows(arguments.update, target, kinds)
        page.update()
    else:
        check_budgets(arguments.budgets, target, kinds)
