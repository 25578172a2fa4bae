"""The files of a batch, without what differs from run to run."""
import json
import os
import re
import zlib

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
                for key in ("stage_seconds", "elapsed_s", "peak_memory_bytes"):
                    contents.pop(key, None)
                # The file of the result that has these.
                for file in contents.get("files", ()):
                    if file["name"] == "result.json":
                        del file["bytes"], file["crc32"]
            elif name == "fleet.html":
                contents = re.sub(rb"<td>[0-9.]+</td>(?=<td>[^<]*</td></tr>)|[Rr]un time per unit [^<]*", b"", contents)
            elif name == "fleet.csv":
                contents = [line.rsplit(b",", 1)[0] for line in contents.splitlines()]
            files[os.path.relpath(path, folder)] = contents
    return files


def record_files(folder):
    """Lets unit.json say that a result's files are as they are now."""
    path = os.path.join(folder, "unit.json")
    record = json.loads(read(path))
    for file in record["files"]:
        contents = read(os.path.join(folder, file["name"]))
        file["bytes"], file["crc32"] = len(contents), zlib.crc32(contents)
    with open(path, "w", encoding="utf-8") as file:
        json.dump(record, file)


def waits_for_a_lock(folder):
    """Whether a process waits for a unit of the folder that another one works on."""
    inode = str(os.stat(folder + "/.batch.lock").st_ino).encode()
    return any(b"->" in line and inode in re.split(rb"[:\s]+", line) for line in read("/proc/locks").splitlines())
