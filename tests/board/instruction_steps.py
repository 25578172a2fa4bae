#!/usr/bin/env python3
"""Executed instructions of the runtime's calls on Linux boards, against the ceilings of
budgets.toml.

QEMU's user mode notes every instruction, with the function that it belongs to; a call's are those
between two of mark_call(). --update writes the target's rows of runtime/cost.
"""
import argparse
import subprocess
import sys

import cost_tables


def count_calls(emulator, program):
    """Instructions of each call of the program: between the marks before and after it."""
    command = [emulator[0], "-singlestep", "-d", "exec,nochain", "-D", "/dev/stdout",
               *emulator[1:], program]
    counts, number, was_mark = [], 0, False
    with subprocess.Popen(command, stdout=subprocess.PIPE, bufsize=1 << 20) as process:
        for line in process.stdout:
            if line.startswith(b"Trace"):
                is_mark = line.endswith(b" mark_call\n")
                if is_mark and not was_mark:
                    counts.append(number)
                number, was_mark = 0 if is_mark else number + 1, is_mark
    if process.returncode != 0:
        sys.exit(f"instruction_steps: {' '.join(command)} failed")
    return counts[1::2]


def measure(emulator, program):
    """Instructions a point or pixel, to a decimal, by the call's name."""
    listing = subprocess.run([*emulator, program, "names"], check=True, capture_output=True,
                             text=True).stdout
    calls = [line.split() for line in listing.splitlines()]
    counts = count_calls(emulator, program)
    if len(counts) != len(calls):
        sys.exit(f"instruction_steps: {len(counts)} calls are marked, not {len(calls)}")
    figures = {name: round(count / int(units), 1) for (name, units), count in zip(calls, counts)}
    for name, figure in figures.items():
        print(f"instructions of {name}: {figure}")
    return figures


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--target", required=True)
    cost_tables.add_arguments(parser)
    parser.add_argument("--program", required=True)
    parser.add_argument("--emulator", nargs=argparse.REMAINDER, required=True)
    arguments = parser.parse_args()
    figures = measure(arguments.emulator, arguments.program)
    kinds = {"points": {}, "frames": {}}
    for name, figure in figures.items():
        kinds["frames" if name.startswith("remap") else "points"][name] = figure
    cost_tables.settle(arguments, arguments.target, kinds)


if __name__ == "__main__":
    main()
