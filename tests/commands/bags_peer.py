"""PyPI's rosbags, mcap and foxglove-schemas-protobuf write bags of images, and read those of raygrid.
  bags_peer.py write IMAGES.npy FOLDER   images: N x rows x columns of 8 bits; a stamp every 0.1 s
  bags_peer.py read BAG                  topic, type, stamp and size of each message, as JSON"""
import json
import os
import sys

import numpy
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf.timestamp_pb2 import Timestamp
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer as McapWriter
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_typestore

TOPIC = "/cam0/image_raw"
ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
IMAGE = """std_msgs/Header header
uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def stamp(k):
    return 1700000000 * 10**9 + 100000000 * k


def message(store, image, k, **more):
    time = store.types["builtin_interfaces/msg/Time"](*divmod(stamp(k), 10**9))
    header = store.types["std_msgs/msg/Header"](stamp=time, frame_id="cam0", **more)
    return store.types["sensor_msgs/msg/Image"](header, *image.shape, "mono8", 0, image.shape[1], image.ravel())


def write(images, folder):
    kind = "sensor_msgs/msg/Image"
    for name, method in (("none", None), ("bz2", rosbag1.Writer.CompressionFormat.BZ2),
                         ("lz4", rosbag1.Writer.CompressionFormat.LZ4)):
        writer = rosbag1.Writer(os.path.join(folder, name + ".bag"))
        if method:
            writer.set_compression(method)
        with writer:
            connection = writer.add_connection(TOPIC, kind, typestore=ROS1)
            for k, image in enumerate(images):
                writer.write(connection, stamp(k), ROS1.serialize_ros1(message(ROS1, image, k, seq=k), kind))
    zstd = rosbag2.CompressionFormat.ZSTD
    for name, plugin, mode in (("sqlite", 1, None), ("sqlite_file", 1, 2), ("sqlite_message", 1, 3),
                               ("mcap", 2, None), ("mcap_file", 2, 2), ("mcap_message", 2, 3), ("mcap_storage", 2, 4)):
        writer = rosbag2.Writer(os.path.join(folder, name), version=9, storage_plugin=rosbag2.StoragePlugin(plugin))
        if mode:
            writer.set_compression(rosbag2.CompressionMode(mode), zstd)
        with writer:
            connection = writer.add_connection(TOPIC, kind, typestore=ROS2)
            for k, image in enumerate(images):
                writer.write(connection, stamp(k), ROS2.serialize_cdr(message(ROS2, image, k), kind))
    for method in CompressionType:
        with open(os.path.join(folder, method.name.lower() + ".mcap"), "wb") as file:
            writer = McapWriter(file, compression=method)
            schema = writer.register_msgdef(kind, IMAGE)
            for k, image in enumerate(images):
                seconds, nanoseconds = divmod(stamp(k), 10**9)
                writer.write_message(TOPIC, schema, {
                    "header": {"stamp": {"sec": seconds, "nanosec": nanoseconds}, "frame_id": "cam0"},
                    "height": image.shape[0], "width": image.shape[1], "encoding": "mono8", "is_bigendian": 0,
                    "step": image.shape[1], "data": image.tobytes()}, stamp(k), stamp(k), k)
            writer.finish()


def write_foxglove(images, folder):
    with open(os.path.join(folder, "foxglove.mcap"), "wb") as file:
        writer = Writer(file)
        writer.start()
        topics = {}
        for topic, kind in ((TOPIC, RawImage), ("/info", CameraCalibration)):
            schema = writer.register_schema(kind.DESCRIPTOR.full_name, "protobuf", b"")
            topics[kind] = writer.register_channel(topic, "protobuf", schema)
        for k, image in enumerate(images):
            time = Timestamp(seconds=stamp(k) // 10**9, nanos=stamp(k) % 10**9)
            rows, columns = image.shape
            for one in (RawImage(timestamp=time, frame_id="cam0", width=columns, height=rows, encoding="mono8",
                                 step=columns, data=image.tobytes()),
                        CameraCalibration(timestamp=time, frame_id="cam0", width=columns, height=rows,
                                          distortion_model="plumb_bob", D=[0.1, 0, 0, 0, 0],
                                          K=[9, 0, 7, 0, 8, 6, 0, 0, 1])):
                writer.add_message(topics[type(one)], stamp(k), one.SerializeToString(), stamp(k))
        writer.finish()


def read(path):
    messages = []
    with open(path, "rb") as file:
        for schema, channel, found, decoded in make_reader(
                file, validate_crcs=True, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            row = {"topic": channel.topic, "type": schema.name, "log_ns": found.log_time, "bytes": len(found.data)}
            if hasattr(decoded, "header"):
                row["stamp_ns"] = decoded.header.stamp.sec * 10**9 + decoded.header.stamp.nanosec
            for key in ("width", "height", "encoding", "step", "distortion_model"):
                if hasattr(decoded, key):
                    row[key] = getattr(decoded, key)
            for key in ("k", "p", "d"):
                if hasattr(decoded, key):
                    row[key] = list(getattr(decoded, key))
            if hasattr(decoded, "transforms"):
                row["transforms"] = [[one.header.frame_id, one.child_frame_id, [
                    getattr(one.transform.translation, axis) for axis in "xyz"]] for one in decoded.transforms]
            messages.append(row)
    print(json.dumps(messages))


if sys.argv[1] == "write":
    write(numpy.load(sys.argv[2]), sys.argv[3])
    write_foxglove(numpy.load(sys.argv[2]), sys.argv[3])
else:
    read(sys.argv[2])
