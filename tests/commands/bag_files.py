"""Bags of tests, without a library: MCAP, ROS 1 and rosbag2's SQLite. Compressed data are stored as they are, in frames
of their method."""
import bz2
import contextlib
import json
import os
import sqlite3
import struct
import zlib

from command_test import write


def lz4(data):
    """A frame of independent blocks without checksums."""
    blocks = [data[at:at + (1 << 16)] for at in range(0, len(data), 1 << 16)]
    return (b"\x04\x22\x4d\x18\x60\x40\x82" +
            b"".join(struct.pack("<I", 1 << 31 | len(block)) + block for block in blocks) + bytes(4))


def zstd(data):
    """A frame of raw blocks."""
    blocks = [data[at:at + (1 << 16)] for at in range(0, len(data), 1 << 16)] or [b""]
    return (struct.pack("<IBI", 0xfd2fb528, 0xa0, len(data)) +
            b"".join(struct.pack("<I", len(block) << 3 | (k == len(blocks) - 1))[:3] + block
                     for k, block in enumerate(blocks)))


COMPRESS = {"": bytes, "none": bytes, "lz4": lz4, "zstd": zstd, "bz2": bz2.compress}


class Fields:
    """Serialized fields: of ROS 1, or of CDR in one of two byte orders."""

    def __init__(self, encoding, order="<"):
        self.is_cdr, self.order = encoding == "cdr", order
        self.start = bytes((0, order == "<", 0, 0)) if self.is_cdr else b""
        self.bytes = b""

    def put(self, kind, *values):
        for value in values:
            if self.is_cdr:
                self.bytes += bytes(-len(self.bytes) % struct.calcsize(kind))
            self.bytes += struct.pack(self.order + kind, value)
        return self

    def put_bytes(self, data):
        self.put("I", len(data))
        self.bytes += data
        return self

    def text(self, text):
        return self.put_bytes(text.encode() + (b"\0" if self.is_cdr else b""))

    def header(self, stamp_ns, frame="cam"):
        if not self.is_cdr:
            self.put("I", 0)
        return self.put("I", *divmod(stamp_ns, 10**9)).text(frame)

    def message(self):
        return self.start + self.bytes


def image(stamp_ns, size, pixels, kind="mono8", step=None, encoding="cdr", order="<", big_endian=0):
    """A message of sensor_msgs/Image."""
    return (Fields(encoding, order).header(stamp_ns).put("I", size[1], size[0]).text(kind).put("B", big_endian)
            .put("I", step or len(pixels) // size[1]).put_bytes(pixels).message())


def compressed(stamp_ns, file, encoding="cdr"):
    """A message of sensor_msgs/CompressedImage."""
    return Fields(encoding).header(stamp_ns).text("jpeg").put_bytes(file).message()


def camera_info(stamp_ns, size, k, d, model="plumb_bob", binning=0, roi=(0, 0, 0, 0), encoding="cdr"):
    fields = Fields(encoding).header(stamp_ns).put("I", size[1], size[0]).text(model).put("I", len(d)).put("d", *d)
    fields.put("d", *k).put("d", 1, 0, 0, 0, 1, 0, 0, 0, 1).put("d", *k[:3], 0, *k[3:6], 0, *k[6:], 0)
    return fields.put("I", binning, binning, *roi).put("B", 0).message()


class Message:
    def __init__(self, topic, data, log_ns, type="sensor_msgs/msg/Image", encoding="cdr"):
        self.topic, self.data, self.log_ns, self.type, self.encoding = topic, data, log_ns, type, encoding


# ---- MCAP

def record(opcode, content):
    return struct.pack("<BQ", opcode, len(content)) + content


def mcap_text(text):
    return struct.pack("<I", len(text)) + text.encode()


def chunk(records, compression):
    data = COMPRESS[compression](records)
    return record(6, struct.pack("<QQQI", 0, 0, len(records), zlib.crc32(records)) + mcap_text(compression) +
                  struct.pack("<Q", len(data)) + data)


MCAP_END = record(15, bytes(4)) + record(2, bytes(20)) + b"\x89MCAP0\r\n"


def mcap(messages, compression="", per_chunk=3):
    """A file with chunks, or, with per_chunk 0, without."""
    declared, parts, records = {}, [], b""
    for k, message in enumerate(messages):
        if message.topic not in declared:
            declared[message.topic] = number = len(declared) + 1
            records += record(3, struct.pack("<H", number) + mcap_text(message.type) + mcap_text("ros2msg") + bytes(4))
            records += record(4, struct.pack("<HH", number, number) + mcap_text(message.topic) +
                              mcap_text(message.encoding) + bytes(4))
        records += record(5, struct.pack("<HIQQ", declared[message.topic], k, message.log_ns, message.log_ns) +
                          message.data)
        if per_chunk and (k + 1) % per_chunk == 0:
            parts.append(chunk(records, compression))
            records = b""
    if records:
        parts.append(chunk(records, compression) if per_chunk else records)
    return (b"\x89MCAP0\r\n" + record(1, mcap_text("ros2") + mcap_text("test")) + b"".join(parts) + MCAP_END)


# ---- ROS 1

def fields(**values):
    parts = [key.encode() + b"=" + value for key, value in values.items()]
    return b"".join(struct.pack("<I", len(part)) + part for part in parts)


def ros1_record(data, **header):
    start = fields(**header)
    return struct.pack("<I", len(start)) + start + struct.pack("<I", len(data)) + data


def ros1(messages, compression="none", per_chunk=3, index=True):
    declared, chunks, records = {}, [], b""

    def finish():
        data = COMPRESS[compression](records)
        chunks.append(ros1_record(data, op=b"\5", compression=compression.encode(),
                                  size=struct.pack("<I", len(records))))
    for k, message in enumerate(messages):
        if message.topic not in declared:
            declared[message.topic] = len(declared)
            kind = message.type.replace("/msg/", "/").encode()
            records += ros1_record(fields(topic=message.topic.encode(), type=kind, md5sum=b"*", message_definition=b""),
                                   op=b"\7", conn=struct.pack("<I", declared[message.topic]),
                                   topic=message.topic.encode())
        seconds, nanoseconds = divmod(message.log_ns, 10**9)
        records += ros1_record(message.data, op=b"\2", conn=struct.pack("<I", declared[message.topic]),
                               time=struct.pack("<II", seconds, nanoseconds))
        if (k + 1) % per_chunk == 0:
            finish()
            records = b""
    if records:
        finish()
    counts = struct.pack("<I", len(declared)), struct.pack("<I", len(chunks))
    header = fields(op=b"\3", index_pos=struct.pack("<Q", index), conn_count=counts[0], chunk_count=counts[1])
    padding = bytes(4096 - 8 - len(header))
    return (b"#ROSBAG V2.0\n" + struct.pack("<I", len(header)) + header + struct.pack("<I", len(padding)) + padding +
            b"".join(chunks))


# ---- rosbag2

def database(path, messages, compression=""):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with contextlib.closing(sqlite3.connect(path)) as file, file:
        file.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, "
                     "offered_qos_profiles TEXT)")
        file.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
        declared = {}
        for message in messages:
            if message.topic not in declared:
                declared[message.topic] = len(declared) + 1
                file.execute("INSERT INTO topics VALUES(?, ?, ?, ?, '')",
                             (declared[message.topic], message.topic, message.type, message.encoding))
            file.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)",
                         (declared[message.topic], message.log_ns, COMPRESS[compression](message.data)))
    return path


def metadata(*files):
    return json.dumps({"rosbag2_bagfile_information": {"version": 5, "relative_file_paths": files}})


def folder(path, name, contents):
    """A folder of rosbag2 with one file."""
    write(os.path.join(path, name), contents)
    write(os.path.join(path, "metadata.yaml"), metadata(name))
    return path
