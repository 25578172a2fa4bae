#!/usr/bin/env python3
"""A type's name is that of one header: two of one name are one to the linker, and memory goes bad."""
import collections
import glob
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DEFINITION = re.compile(r"^(?:struct|class|enum(?: class)?) (\w+)\b[^;{]*\{", re.MULTILINE)

headers = collections.defaultdict(set)
for path in sorted(glob.glob(os.path.join(ROOT, "offline/**/*.h"), recursive=True) +
                   glob.glob(os.path.join(ROOT, "tools/*.h"))):
    with open(path, encoding="utf-8") as file:
        for name in DEFINITION.findall(file.read()):
            headers[name].add(os.path.relpath(path, ROOT))
clashes = {name: sorted(files) for name, files in headers.items() if len(files) > 1}
for name, files in clashes.items():
    print(f"{name}: defined in {' and '.join(files)}; rename one")
print(f"{len(headers)} types in headers")
sys.exit(1 if clashes or len(headers) < 100 else 0)
