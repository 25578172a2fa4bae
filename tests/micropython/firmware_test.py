#!/usr/bin/env python3
"""The module raygrid in firmware of a Cortex-M3 with MicroPython, which QEMU runs.

    firmware_test.py FIRMWARE    with formats and tests/golden in PYTHONPATH
"""
import re
import subprocess
import sys

import blob_reference as reference
import make_golden

# The frame is made on the board, and the CRC is counted there.
SCRIPT = """
import raygrid
from array import array
camera = raygrid.Camera({blob!r})
frame = bytearray(160 * 120)
state = 2025
for k in range(len(frame)):
    state = (1664525 * state + 1013904223) & 0xffffffff
    frame[k] = (2 * (k % 160) + k // 160 + (state >> 27)) & 255
width, height = camera.remap_size()
out = bytearray(width * height)
camera.undistort(frame, out, raygrid.GREY8, {border})
crc = 0xffffffff
for byte in out:
    crc ^= byte
    for _ in range(8):
        crc = (crc >> 1) ^ (0xedb88320 if crc & 1 else 0)
print("remap CRC %08x" % (crc ^ 0xffffffff))
ray = array("f", [0, 0, 0])
camera.unproject(array("f", [80, 60]), ray)
print("ray", *ray)
"""
RAW, END = b"\r\x01", b"\x04"  # a script for MicroPython, without echoes


def main():
    blob = make_golden.make_lens()
    script = SCRIPT.format(blob=reference.serialize(blob), border=make_golden.BORDER)
    command = ["qemu-system-arm", "-machine", "mps2-an385", "-nographic", "-monitor", "none",
               "-semihosting", "-serial", "stdio", "-kernel", sys.argv[1]]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as machine:
        machine.stdin.write(RAW + script.encode() + END)
        machine.stdin.flush()
        told = b""
        while told.count(END) < 2 and (byte := machine.stdout.read(1)):
            told += byte
        machine.kill()
    text = told.decode(errors="replace")
    print(*re.findall(r"remap CRC \w+|ray .*", text), sep="\n")
    crc = f"remap CRC {make_golden.remap_crc(blob):08x}"
    if crc not in text:
        sys.exit(f"micropython: {crc} was expected, not\n{text}")
    ray = [float(value) for value in text.split("ray ")[-1].split()[:3]]
    if any(abs(a - b) > 2e-7 for a, b in zip(ray, reference.unproject(blob, 80, 60))):
        sys.exit(f"micropython: a wrong ray, {ray}")


if __name__ == "__main__":
    main()
