#!/usr/bin/env python3
"""The cost of the runtime on a board, against the ceilings of budgets.toml.

Flash, RAM and stack from the objects: what a firmware links that calls the entry points of a
set; it may take no static memory and no symbol from outside. The stack is the deepest path of
the compiler's call graph (-fcallgraph-info=su). Executed instructions, of microcontrollers, from
instruction_bench on an emulator that counts them. --update writes the core's rows of runtime/cost.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile

import cost_tables

# Sources that do not go on a board.
HOST_ONLY = ("blob_write", "blob_fields", "blob_limits", "blob_stack", "rg_status")
RAYS = ("rg_camera_open", "rg_unproject", "rg_project")
EVERYTHING = RAYS + (
    "rg_unproject_batch", "rg_unproject_row", "rg_project_batch", "rg_project_point",
    "rg_unproject_line", "rg_unproject_lines", "rg_is_valid", "rg_uncertainty",
    "rg_undistort_point", "rg_undistort_points", "rg_mode_to_calibrated",
    "rg_mode_from_calibrated", "rg_match", "rg_select_remap", "rg_remap_size", "rg_remap_view",
    "rg_frame_size", "rg_calibrated_size", "rg_remap_mode", "rg_remap", "rg_remap_source_rows",
    "rg_remap_grey", "rg_select_ray_kernels")
# .text of what these need. rg_line_delay() is a call more: of those who stabilize or track by rows.
SETS = {"rays": RAYS, "grey": RAYS + ("rg_select_remap", "rg_remap_size", "rg_remap_grey"),
        "everything": EVERYTHING, "slots": ("rg_select_slot",)}
# Stack of these, each for itself, and the deepest of the others.
STACKS = ("rg_camera_open", "rg_select_remap", "rg_unproject", "rg_unproject_line", "rg_project",
          "rg_undistort_point", "rg_remap_grey", "rg_remap", "rg_remap_source_rows", "rg_match")
# Functions that call by a pointer that may be NULL, and then do not: with conditions of a stack,
# what rg_set_operating_point() points to.
MAY_CALL_NOTHING = ("process_tile_by_rows", "rg_unproject", "rg_unproject_line", "find_pixel",
                    "rg_project_batch", "next_tile", "rg_select_remap")
# Who calls what rg_set_operating_point() points to; other calls by pointers are of other functions.
CALLERS_WITH_CONDITIONS = {
    "evaluate_grid": ("rg_unproject", "rg_unproject_line", "find_pixel", "rg_project_batch"),
    "evaluate_inverse": ("find_pixel", "rg_project_batch"),
    # One of the two: the latter is for the small walk.
    "check_vertices": ("rg_select_remap",), "rg_next_blended_tile": ("next_tile",)}


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--core", required=True)
    cost_tables.add_arguments(parser)
    parser.add_argument("--compiler", required=True)
    parser.add_argument("--formats", nargs="+", required=True)
    parser.add_argument("--runtime", nargs="+", required=True)
    parser.add_argument("--bench", nargs=argparse.REMAINDER,
                        help="emulator, its options and the program; the last argument")
    return parser.parse_args()


def tool(compiler, name):
    """The binutils beside a cross compiler: arm-none-eabi-gcc -> arm-none-eabi-nm."""
    return re.sub(r"gcc$", name, compiler)


def board_objects(objects):
    return [o for o in objects if not any(skip in os.path.basename(o) for skip in HOST_ONLY)]


def link(compiler, objects, output, roots):
    """One object of what the roots need."""
    keep = [option for root in roots for option in ("-u", root)]
    emulation = ["-m", "elf32lriscv"] if compiler.endswith("riscv64-unknown-elf-gcc") else []
    subprocess.run([tool(compiler, "ld"), *emulation, "-r", "--gc-sections", *keep, "-o", output,
                    *objects], check=True)


def section_sizes(compiler, path):
    """Bytes of code with constants, and of static memory. Constants that hold addresses are
    .data.rel.ro in code that is independent of its position; tables for unwinding do not count."""
    lines = subprocess.run([tool(compiler, "size"), "-A", path], check=True, capture_output=True,
                           text=True).stdout.splitlines()
    sections = [line.split()[:2] for line in lines if line.startswith(".")]

    def total(pattern):
        return sum(int(size) for name, size in sections if re.match(pattern, name))
    return (total(r"\.(text|literal|s?rodata|data\.rel\.ro)"),
            total(r"\.(s?data(?!\.rel\.ro)|s?bss|tdata|tbss)"))


def undefined_symbols(compiler, path):
    output = subprocess.run([tool(compiler, "nm"), "-u", path], check=True, capture_output=True,
                            text=True).stdout
    names = [line.split()[-1] for line in output.splitlines() if line.strip()]
    return [name for name in names if name != "_GLOBAL_OFFSET_TABLE_"] # the linker's own


def find_jumps(compiler, path):
    """Calls of an object that are always jumps, as (function, function): the caller's stack is
    free by then. Known from relocations of Arm; none on other cores."""
    output = subprocess.run([tool(compiler, "objdump"), "-dr", path], check=True,
                            capture_output=True, text=True).stdout
    jumps, calls, caller = set(), set(), ""
    for line in output.splitlines():
        title = re.match(r"[0-9a-f]+ <(\w+)>:", line)
        target = re.search(r"R_(?:ARM_THM|AARCH64)_(JUMP2|CALL)\d*\s+(?:\.text\.)?(\w+)", line)
        caller = title.group(1) if title else caller
        if target:
            (jumps if target.group(1) == "JUMP2" else calls).add((caller, target.group(2)))
    return jumps - calls


def find_taken(compiler, path):
    """Functions whose addresses an object takes, as (function that takes it, or "" for data,
    taken function)."""
    output = subprocess.run([tool(compiler, "objdump"), "-r", path], check=True,
                            capture_output=True, text=True).stdout
    taken, taker = set(), None
    for line in output.splitlines():
        section = re.match(r"RELOCATION RECORDS FOR \[(\.\w+)(?:\.(\w+))?", line)
        target = re.search(r"\bR_\w+\s+(?:\.text\.)?(\w+)", line)
        if section:
            takers = {".text": section.group(2), ".literal": section.group(2), ".data": "",
                      ".rodata": "", ".srodata": ""}
            taker = takers.get(section.group(1))
        elif taker is not None and target and not re.search(r"CALL|JUMP|JAL|BRANCH|SLOT", line):
            taken.add((taker, target.group(1)))
    return taken


def name_of(title):
    """A function's name; the graph has a file before that of a static one."""
    return title.rsplit(":", 1)[-1]


def read_call_graph(compiler, objects):
    """Stack bytes of each function, and the functions that it calls, jumps to when it is done, so
    that they need no stack beside its own, or takes the address of; "" for data."""
    stack, calls, takers = {}, {}, []
    for path in objects:
        jumps = find_jumps(compiler, path)
        with open(os.path.splitext(path)[0] + ".ci", encoding="utf-8") as file:
            text = file.read()
        titles = {}
        for title, size in re.findall(r'node: { title: "([^"]+)" label: "[^"]*?(\d+) bytes', text):
            stack[title] = int(size)
            titles[name_of(title)] = title
        for source, target in re.findall(r'sourcename: "([^"]+)" targetname: "([^"]+)"', text):
            is_jump = (name_of(source), name_of(target)) in jumps
            calls.setdefault(source, set()).add((target, "jump" if is_jump else "call"))
        takers += [(titles.get(source, source), titles.get(target, target))
                   for source, target in find_taken(compiler, path)]
    for source, target in takers:
        if target in stack:
            calls.setdefault(source, set()).add((target, "taken"))
    return stack, calls


def may_call(function, pointed):
    """Whether a function that calls by a pointer may call another one."""
    callers = CALLERS_WITH_CONDITIONS.get(name_of(pointed))
    with_conditions = {name for names in CALLERS_WITH_CONDITIONS.values() for name in names}
    return name_of(function) in callers if callers else name_of(function) not in with_conditions


def deepest(function, stack, calls, path=()):
    """Stack of the deepest path from a function. Functions that are called by pointers are those
    that data or a function of the path takes the address of."""
    if function in path:
        sys.exit(f"footprint: {function} calls itself")
    own, path = stack.get(function, 0), path + (function,)
    below = [own]
    for callee, kind in calls.get(function, ()):
        if callee == "__indirect_call":
            taken = {pointed for caller in ("",) + path for pointed, kind in calls.get(caller, ())
                     if kind == "taken" and may_call(function, pointed)} - set(path)
            if not taken and name_of(function) not in MAY_CALL_NOTHING:
                sys.exit(f"footprint: {function} calls a function that no one points to")
            below += [own + deepest(pointed, stack, calls, path) for pointed in taken]
        elif kind != "taken":
            below.append((0 if kind == "jump" else own) + deepest(callee, stack, calls, path))
    return max(below)


def measure_text(arguments, objects, roots):
    """Bytes of .text; exits if there is static memory or a symbol from outside."""
    with tempfile.TemporaryDirectory() as folder:
        linked = os.path.join(folder, "raygrid.o")
        link(arguments.compiler, objects, linked, roots)
        text, static = section_sizes(arguments.compiler, linked)
        undefined = undefined_symbols(arguments.compiler, linked)
    if static:
        sys.exit(f"footprint: {static} bytes of static memory")
    if undefined:
        sys.exit(f"footprint: needs symbols from outside: {', '.join(undefined)}")
    return text


def measure_texts(arguments, objects):
    """Bytes of .text of each set."""
    texts = {name: measure_text(arguments, objects, roots) for name, roots in SETS.items()}
    for name, text in texts.items():
        print(f".text of {name}: {text} B")
    return texts


def measure_conditions(arguments, objects, texts, bench):
    """What conditions of a stack cost: bytes of .text beside those of grey frames, bytes of the
    deepest stack of all calls, and the bench's figures."""
    text = measure_text(arguments, objects, SETS["grey"] + ("rg_set_operating_point",)) - texts["grey"]
    stack, calls = read_call_graph(arguments.compiler, objects)
    missing = set(CALLERS_WITH_CONDITIONS) - set(map(name_of, stack))
    if missing not in ({"check_vertices"}, {"rg_next_blended_tile"}):
        sys.exit(f"footprint: no functions {', '.join(sorted(missing))}; rename them here as well")
    depth = max(deepest(entry, stack, calls) for entry in EVERYTHING + ("rg_set_operating_point",))
    print(f".text of conditions: {text} B\nstack of conditions: {depth} B")
    figures = {name: bench.pop(name) for name in list(bench) if name.startswith("stack_")}
    return {"text": text, "stack": depth, **figures}


def measure_stacks(arguments, objects):
    """Bytes of stack of the calls that stand by themselves, and the most of all others, of programs
    without conditions."""
    plain = [path for path in objects if not os.path.basename(path).startswith("operating_point.")]
    stack, calls = read_call_graph(arguments.compiler, plain)
    missing = [entry for entry in EVERYTHING if entry not in stack]
    if missing:
        sys.exit(f"footprint: no call graph for {missing}")
    depths = {entry: deepest(entry, stack, calls) for entry in EVERYTHING}
    for entry, depth in depths.items():
        print(f"stack of {entry}: {depth} B")
    others = max(depth for entry, depth in depths.items() if entry not in STACKS)
    return {**{entry: depths[entry] for entry in STACKS}, "others": others}


def measure_instructions(command):
    """Instructions per call or pixel, by the bench's names."""
    output = subprocess.run(command, check=True, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, text=True).stdout
    figures = dict(line.split() for line in output.splitlines() if line.strip())
    for name, hundredths in figures.items():
        print(f"instructions of {name}: {int(hundredths) / 100}")
    return {name: round(int(hundredths) / 100) for name, hundredths in figures.items()}


def main():
    arguments = parse_arguments()
    objects = board_objects(arguments.formats + arguments.runtime)
    kinds = {"text": measure_texts(arguments, objects), "stack": measure_stacks(arguments, objects)}
    bench = measure_instructions(arguments.bench) if arguments.bench else {}
    kinds["conditions"] = measure_conditions(arguments, objects, kinds["text"], bench)
    if bench:
        kinds["instructions"] = bench
    else:
        kinds["conditions of Linux"] = kinds.pop("conditions")
    cost_tables.settle(arguments, arguments.core, kinds)


if __name__ == "__main__":
    main()
