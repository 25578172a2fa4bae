"""The files of a batch, without what differs from run to run."""
import json
import os
import re

from command_test import read


def result_files(folder):
    """All files by their names, but for the times and the memory that a run took."""
    files = {}
    for place, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(place, name)
            contents = read(path)
            if name in ("result.json", "unit.json"):
                contents = json.loads(contents)
                for key in ("seconds", "peak_memory_bytes"):
                    contents.pop(key, None)
            elif name == "fleet.html":
                contents = re.sub(rb"<td>[0-9.]+</td>(?=<td>[^<]*</td></tr>)|A unit took [^<]*", b"", contents)
            elif name == "fleet.csv":
                contents = [line.rsplit(b",", 1)[0] for line in contents.splitlines()]
            files[os.path.relpath(path, folder)] = contents
    return files


def waits_for_a_lock(folder):
    """Whether a process waits for a unit of the folder that another one works on."""
    inode = str(os.stat(folder + "/.batch.lock").st_ino).encode()
    return any(b"->" in line and inode in re.split(rb"[:\s]+", line) for line in read("/proc/locks").splitlines())
