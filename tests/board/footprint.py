#!/usr/bin/env python3
"""Flash, RAM and stack of open + validate + un-project + remap, from the objects.

Links the objects that a firmware needs into one, and checks that it takes no
static memory, needs no symbol from outside, and stays within the limits given.
The stack is the deepest path of the compiler's call graph (-fcallgraph-info=su).
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile

# Sources that do not go on a board.
HOST_ONLY = ("blob_write", "rg_status")
ENTRY_POINTS = ("rg_camera_open", "rg_unproject", "rg_unproject_batch", "rg_project_batch",
                "rg_remap_grey")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--compiler", required=True)
    parser.add_argument("--formats", nargs="+", required=True)
    parser.add_argument("--runtime", nargs="+", required=True)
    parser.add_argument("--max-text", type=int, required=True)
    parser.add_argument("--max-stack", type=int, required=True)
    return parser.parse_args()


def tool(compiler, name):
    """The binutils beside a cross compiler: arm-none-eabi-gcc -> arm-none-eabi-nm."""
    return re.sub(r"gcc$", name, compiler)


def board_objects(objects):
    return [o for o in objects if not any(skip in os.path.basename(o) for skip in HOST_ONLY)]


def link(compiler, objects, output):
    subprocess.run([tool(compiler, "ld"), "-r", "-o", output, *objects], check=True)


def section_sizes(compiler, path):
    """Bytes of (text, data, bss); text holds read-only data too."""
    lines = subprocess.run([tool(compiler, "size"), path], check=True, capture_output=True,
                           text=True).stdout.splitlines()
    return tuple(int(field) for field in lines[1].split()[:3])


def undefined_symbols(compiler, path):
    output = subprocess.run([tool(compiler, "nm"), "-u", path], check=True, capture_output=True,
                            text=True).stdout
    return [line.split()[-1] for line in output.splitlines() if line.strip()]


def read_call_graph(objects):
    """Stack bytes of each function, and the functions that it calls."""
    stack, calls = {}, {}
    for path in objects:
        with open(os.path.splitext(path)[0] + ".ci", encoding="utf-8") as file:
            text = file.read()
        for title, size in re.findall(r'node: { title: "([^"]+)" label: "[^"]*?(\d+) bytes', text):
            stack[title] = int(size)
        for source, target in re.findall(r'sourcename: "([^"]+)" targetname: "([^"]+)"', text):
            calls.setdefault(source, set()).add(target)
    return stack, calls


def deepest(function, stack, calls, path=()):
    """Stack of the deepest path from a function."""
    if function in path:
        sys.exit(f"footprint: {function} calls itself")
    below = [deepest(callee, stack, calls, path + (function,)) for callee in calls.get(function, ())]
    return stack.get(function, 0) + max(below, default=0)


def main():
    arguments = parse_arguments()
    objects = board_objects(arguments.formats + arguments.runtime)
    with tempfile.TemporaryDirectory() as folder:
        linked = os.path.join(folder, "raygrid.o")
        link(arguments.compiler, objects, linked)
        text, data, bss = section_sizes(arguments.compiler, linked)
        undefined = undefined_symbols(arguments.compiler, linked)
    stack, calls = read_call_graph(objects)
    depths = {entry: deepest(entry, stack, calls) for entry in ENTRY_POINTS}

    print(f".text {text} B (at most {arguments.max_text}), .data {data} B, .bss {bss} B")
    for entry, depth in depths.items():
        print(f"stack of {entry}: {depth} B (at most {arguments.max_stack})")
    print("symbols from outside:", ", ".join(undefined) or "none")
    missing = [entry for entry in ENTRY_POINTS if entry not in stack]
    faults = [
        (missing, f"no call graph for {missing}"),
        (text > arguments.max_text, "too much .text"),
        (data or bss, "static memory"),
        (max(depths.values()) > arguments.max_stack, "too much stack"),
        (undefined, "needs symbols from outside"),
    ]
    for fault, message in faults:
        if fault:
            sys.exit(f"footprint: {message}")


if __name__ == "__main__":
    main()
