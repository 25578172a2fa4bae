#!/usr/bin/env python3
"""How many comments lean on their neighbours: those that begin without a subject.

    comments_test.py            compares each folder with its limit
    comments_test.py FILE...    lists the comments of the files that lean

An editor shows a comment alone, so that "Of the edge." or "The same, but upright." says nothing
there. Consecutive lines of // are one comment.
"""
import os
import re
import sys

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
# Limits only ever fall.
LIMITS = {"formats": 0, "offline": 0, "runtime": 0, "tests": 0, "tools": 0}
# Literals are matched first, so that nothing in them is taken for a comment.
TOKEN = re.compile(r"""
    (?P<literal> R"(?P<mark>[^\s()\\]*)\(.*?\)(?P=mark)" | "(?:\\.|[^"\\\n])*" | '(?:\\.|[^'\\\n])+' )
  | (?P<comment> /\*.*?\*/ | //[^\n]*(?:\n[ \t]*//[^\n]*)* )
""", re.DOTALL | re.VERBOSE)
LEANS = re.compile(r"[/*!<\s]*(What|Of|Where|As|Likewise|Both|The\s[/*\s]*same)\b")


def list_leaning(path):
    """Numbers of the lines on which comments of the file lean, each with the comment's words."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    for match in TOKEN.finditer(text):
        comment = match.group("comment")
        if comment and LEANS.match(comment):
            yield text.count("\n", 0, match.start()) + 1, comment.split("\n")[0]


def list_sources(folder):
    for parent, _, names in sorted(os.walk(os.path.join(ROOT, folder))):
        for name in sorted(names):
            if name.endswith((".c", ".h", ".cc")):
                yield os.path.join(parent, name)


def describe(paths):
    return [f"{os.path.relpath(path, ROOT)}:{line}: {words}"
            for path in paths for line, words in list_leaning(path)]


def main():
    if sys.argv[1:]:
        print("\n".join(describe(os.path.abspath(path) for path in sys.argv[1:])))
        return
    faults = []
    for folder, limit in LIMITS.items():
        leaning = describe(list_sources(folder))
        print(f"{folder}: {len(leaning)} comments begin without a subject, {limit} may")
        if len(leaning) > limit:
            faults += leaning
    if faults:
        sys.exit("\n".join(faults) + "\nName the subject first, so that each comment makes sense "
                 "by itself.")


if __name__ == "__main__":
    main()
