#!/usr/bin/env python3
"""Executed instructions of the runtime's calls on Linux boards, against the table of its README.

QEMU's user mode notes every instruction; those of two calls less those of one are a call's own.
Remaps in blocks of 32 and of 16. A figure that has grown by more than 2 % fails, and so does one
that has shrunk by more than 10 %; --update writes the README's row.
"""
import argparse
import subprocess
import sys

GROWTH, SHRINKAGE = 1.02, 0.9


def count(emulator, program, *arguments):
    """Instructions of a run."""
    command = [emulator[0], "-singlestep", "-d", "exec,nochain", "-D", "/dev/stdout",
               *emulator[1:], program, *map(str, arguments)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        number = sum(line.startswith(b"Trace") for line in process.stdout)
    if process.returncode != 0:
        sys.exit(f"instruction_steps: {' '.join(command)} failed")
    return number


def measure(emulator, program):
    """Instructions a point, and a pixel in blocks of 32 and of 16; times 10."""
    listing = subprocess.run([*emulator, program], check=True, capture_output=True,
                             text=True).stdout
    figures = []
    for line in listing.splitlines():
        number, name, units = line.split()
        for log2 in (5, 4) if name.startswith("remap") else (4,):
            once, twice = (count(emulator, program, number, times, log2) for times in (1, 2))
            figures.append(round(10 * (twice - once) / int(units)))
            print(f"instructions of {name}, blocks of {1 << log2}: {figures[-1] / 10}")
    return figures


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--target", required=True)
    parser.add_argument("--readme", required=True)
    parser.add_argument("--update", action="store_true")
    parser.add_argument("--program", required=True)
    parser.add_argument("--emulator", nargs=argparse.REMAINDER, required=True)
    arguments = parser.parse_args()
    figures = measure(arguments.emulator, arguments.program)
    with open(arguments.readme, encoding="utf-8") as file:
        lines = file.read().split("\n")
    places = [k for k, line in enumerate(lines) if line.startswith(f"| {arguments.target} |")]
    if len(places) != 1:
        sys.exit(f"instruction_steps: the README has {len(places)} rows of {arguments.target}")
    if arguments.update:
        lines[places[0]] = (f"| {arguments.target} | "
                            + " | ".join(str(figure / 10) for figure in figures) + " |")
        with open(arguments.readme, "w", encoding="utf-8") as file:
            file.write("\n".join(lines))
        return
    expected = [10 * float(cell) for cell in lines[places[0]].split("|")[2:-1]]
    faults = [f"{figure / 10}, but the README says {limit / 10}"
              for figure, limit in zip(figures, expected)
              if figure > limit * GROWTH + 0.5 or figure < limit * SHRINKAGE - 0.5]
    if faults or len(expected) != len(figures):
        sys.exit("instruction_steps: " + "; ".join(faults) + "; if that is as it should be, --update")


if __name__ == "__main__":
    main()
