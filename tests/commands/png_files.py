"""PNG files of tests, without a library."""
import struct
import zlib

from command_test import read


def chunk(kind, contents):
    return (struct.pack(">I", len(contents)) + kind + contents +
            struct.pack(">I", zlib.crc32(kind + contents)))


def png(pixels, size, channels=1, bits=8, chunks=b""):
    """A file of samples, row by row."""
    kind = {1: 0, 3: 2, 4: 6}[channels]
    samples = struct.pack(f">{len(pixels)}{'B' if bits == 8 else 'H'}", *pixels)
    stride = size[0] * channels * bits // 8
    rows = b"".join(b"\0" + samples[at:at + stride] for at in range(0, len(samples), stride))
    return (b"\x89PNG\r\n\x1a\n" +
            chunk(b"IHDR", struct.pack(">IIBBBBB", *size, bits, kind, 0, 0, 0)) + chunks +
            chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b""))


def read_png(path):
    """Channels, bits and samples."""
    file = read(path)
    width, height, bits, kind = struct.unpack(">IIBB", file[16:26])
    channels = {0: 1, 2: 3, 6: 4}[kind]
    packed, at = b"", 8
    while file[at + 4:at + 8] != b"IEND":
        size = struct.unpack(">I", file[at:at + 4])[0]
        if file[at + 4:at + 8] == b"IDAT":
            packed += file[at + 8:at + 8 + size]
        at += 12 + size
    rows, step = zlib.decompress(packed), channels * bits // 8
    stride, before, out = width * step, bytearray(width * step), bytearray()
    for y in range(height):
        line = bytearray(rows[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            left = line[i - step] if i >= step else 0
            corner = before[i - step] if i >= step else 0
            up = before[i]
            near = left + up - corner
            paeth = min((abs(near - left), 0, left), (abs(near - up), 1, up),
                        (abs(near - corner), 2, corner))[2]
            line[i] = line[i] + (0, left, up, (left + up) // 2,
                                 paeth)[rows[y * (stride + 1)]] & 255
        out += line
        before = line
    return channels, bits, struct.unpack(f">{len(out) * 8 // bits}{'B' if bits == 8 else 'H'}", out)
