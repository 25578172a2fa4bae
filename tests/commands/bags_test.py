#!/usr/bin/env python3
"""Bags as images and cameras: every kind gives what a folder of the same images gives, and bad ones are refused."""
import csv
import io
import json
import os
import re
import subprocess
import sys

import bag_files
from bag_files import Message
from command_test import CommandTest, long_test, main, programs, read, run, write
from png_files import png

HERE = os.path.dirname(os.path.abspath(__file__))
VENV = os.path.join(HERE, "..", "..", "build", "bags_peers")
SIZE, SQUARE = (160, 120), 16
PATTERN = "chessboard:6x4:20mm"
START = 1700000000 * 10**9
TOPIC = "/cam0/image_raw"
INFO = "sensor_msgs/msg/CameraInfo"
K = (150.5, 0, 79.25, 0, 151.25, 60.5, 0, 0, 1)


LENS = ("raygrid_camera: 1\nmodel: opencv\nimage_size: [160, 120]\narea: [0, 0, 159, 119]\n"
        "parameters: {fx: 150, fy: 151, cx: 79.5, cy: 59.5, k1: -0.05, k2: 0.01, k3: 0, k4: 0, k5: 0, k6: 0, p1: 0, "
        "p2: 0}\n")


def peers():
    """A Python that has rosbags and mcap, in a folder of the build; None if it cannot be had."""
    python = os.path.join(VENV, "bin", "python")
    has_them = lambda: os.path.exists(python) and subprocess.run(
        [python, "-c", "import rosbags, mcap_ros2, foxglove_schemas_protobuf, numpy"], capture_output=True,
        check=False).returncode == 0
    if not has_them():
        subprocess.run([sys.executable, "-m", "venv", VENV], capture_output=True, check=False)
        subprocess.run([python, "-m", "pip", "install", "-q", "--retries", "0", "--timeout", "5", "rosbags", "mcap",
                        "mcap-ros2-support", "foxglove-schemas-protobuf"], capture_output=True, check=False)
    return python if has_them() else None


def board(k):
    """A chessboard that moves by a pixel from image to image."""
    left, top = 24 + k, 20 + k
    return bytes(30 if 0 <= (x - left) // SQUARE < 7 and 0 <= (y - top) // SQUARE < 5 and
                 ((x - left) // SQUARE + (y - top) // SQUARE) % 2 == 0 else 200
                 for y in range(SIZE[1]) for x in range(SIZE[0]))


IMAGES = [board(k) for k in range(4)]


def stamp(k):
    return START + k * 100000000


def name(k):
    return "%d.%09d" % divmod(stamp(k), 10**9)


def messages(encoding="cdr", topic=TOPIC, shift_ns=0):
    return [Message(topic, bag_files.image(stamp(k) + shift_ns, SIZE, pixels, encoding=encoding), stamp(k) + 1000,
                    encoding=encoding) for k, pixels in enumerate(IMAGES)]


class Bags(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for k, pixels in enumerate(IMAGES):
            write(cls.path(f"images/{name(k)}.png"), png(pixels, SIZE))
        result = run("detect", cls.path("images"), "--pattern", PATTERN, "-o", cls.path("images.csv"))
        assert result.returncode == 0, result.stderr
        cls.features = read(cls.path("images.csv")).replace(b".png,", b",")
        cls.run_mcap = write(cls.path("run.mcap"), bag_files.mcap(messages()))

    def detect(self, *bag):
        return run("detect", *bag, "--pattern", PATTERN, "-o", self.path("bag.csv"))

    def images_of(self, *arguments):
        self.assert_done(self.detect(*arguments))
        rows = csv.DictReader(io.StringIO(read(self.path("bag.csv")).decode()))
        return list(dict.fromkeys(row["image"] for row in rows))

    def assert_same_features(self, *arguments):
        result = self.detect(*arguments)
        self.assert_done(result)
        self.assertEqual(read(self.path("bag.csv")), self.features, arguments)
        return result

    def test_every_kind_has_the_features_of_the_images(self):
        for method in ("", "lz4", "zstd"):
            self.assert_same_features(write(self.path("kind.mcap"), bag_files.mcap(messages(), method)))
        self.assert_same_features(write(self.path("plain.mcap"), bag_files.mcap(messages(), per_chunk=0)))
        for method in ("none", "lz4", "bz2"):
            self.assert_same_features(write(self.path("kind.bag"), bag_files.ros1(messages("ros1"), method)))
        self.assert_same_features(bag_files.database(self.path("kind.db3"), messages()))
        bag_files.database(self.path("sqlite/a.db3"), messages(), "zstd")
        write(self.path("sqlite/metadata.yaml"), bag_files.metadata("a.db3"))
        self.assert_same_features(self.path("sqlite"))
        self.assert_same_features(bag_files.folder(self.path("folder"), "a.mcap.zstd",
                                                   bag_files.zstd(bag_files.mcap(messages()))))

    def test_every_encoding_has_the_features_of_the_images(self):
        def repeated(*words):
            return lambda pixels: b"".join(bytes(p if word == "p" else word for word in words) for p in pixels)
        for kind, convert in (("rgb8", repeated("p", "p", "p")), ("bgra8", repeated("p", "p", "p", 9)),
                              ("yuv422", repeated(128, "p")), ("yuv422_yuy2", repeated("p", 128))):
            bag = [Message(TOPIC, bag_files.image(stamp(k), SIZE, convert(pixels), kind, order=">"), stamp(k))
                   for k, pixels in enumerate(IMAGES)]
            self.assert_same_features(write(self.path("encoding.mcap"), bag_files.mcap(bag)))
        bag = [Message(TOPIC, bag_files.compressed(stamp(k), png(pixels, SIZE)), stamp(k),
                       "sensor_msgs/msg/CompressedImage") for k, pixels in enumerate(IMAGES)]
        self.assert_same_features(write(self.path("encoding.mcap"), bag_files.mcap(bag)))

    def test_images_are_selected(self):
        self.assertEqual(self.images_of(self.run_mcap, "--every", 2), [name(0), name(2)])
        self.assertEqual(self.images_of(self.run_mcap, "--from-s", 0.05, "--to-s", 0.25), [name(1), name(2)])
        self.assertEqual(self.images_of(self.run_mcap, "--stamps", "log", "--every", 4), [name(0)[:-4] + "1000"])
        two = write(self.path("two.mcap"), bag_files.mcap(messages() + messages(topic="/cam1/image_raw")))
        self.assert_same_features(two + ":/cam1/image_raw")
        self.assert_same_features(two, "--topic", TOPIC)
        self.assert_refused(self.detect(two), 1, "2 topics", TOPIC + ", /cam1/image_raw")
        self.assert_refused(self.detect(two, "--topic", "/cam1/image"), 1, "no topic /cam1/image",
                            "/cam1/image_raw, " + TOPIC)
        self.assert_refused(self.detect(self.run_mcap, "--from-s", 9), 2, "from 0.000 to 0.300 s")
        self.assert_refused(self.detect(self.path("images"), "--every", 2), 1, "no bag is given")

    def test_a_truncated_bag_is_read_up_to_its_end(self):
        whole = read(self.run_mcap)
        result = self.detect(write(self.path("cut.mcap"), whole[:whole.rindex(b"mono8")]))
        self.assert_done(result)
        self.assertRegex(result.stderr, r"ends without a summary, within a record at byte \d+")
        self.assertEqual(len(set(read(self.path("bag.csv")).split(b"\n")) - set(self.features.split(b"\n"))), 0)
        result = self.detect(write(self.path("cut.bag"), bag_files.ros1(messages("ros1"), index=False)))
        self.assert_done(result)
        self.assertIn("has no index", result.stderr)

    def test_bad_messages_are_named_counted_and_skipped(self):
        bag = messages()
        bag[1].data = bag[1].data[:100]
        bag[2].data = bag_files.image(stamp(2), SIZE, bytes(4 * len(IMAGES[2])), "32FC1")
        result = self.detect(write(self.path("bad.mcap"), bag_files.mcap(bag)))
        self.assert_done(result)
        self.assertRegex(result.stderr, "2 of 4 messages do not decode and were skipped, the first recorded at "
                                        rf"{name(1)[:-4]}1000: truncated")
        result = self.detect(write(self.path("order.mcap"), bag_files.mcap([messages()[k] for k in (0, 2, 1, 3)])))
        self.assert_done(result)
        self.assertIn(f"stamps run backwards, first at {name(1)}", result.stderr)
        self.assertEqual(read(self.path("bag.csv")), self.features)

    def test_bad_bags_are_refused(self):
        bag = messages()
        bag[2].data = bag_files.image(stamp(2), (80, 120), IMAGES[2][:9600])
        self.assert_refused(self.detect(write(self.path("size.mcap"), bag_files.mcap(bag))), 2,
                            "from 160 x 120 to 80 x 120 pixels at " + name(2))
        depth = [Message("/depth", bag_files.image(stamp(0), (2, 1), bytes(8), "32FC1"), stamp(0))]
        self.assert_refused(self.detect(write(self.path("depth.mcap"), bag_files.mcap(depth))), 2, "no message decodes",
                            "'32FC1' is not that of a camera image")
        imu = [Message("/imu", bytes(9), stamp(0), "sensor_msgs/msg/Imu")]
        path = write(self.path("imu.mcap"), bag_files.mcap(imu))
        self.assert_refused(self.detect(path), 2, "contains no images")
        self.assert_refused(self.detect(path, "--topic", "/imu"), 2, "contains no images")
        self.assert_refused(self.detect(write(self.path("empty.mcap"), "")), 2, "is empty")
        self.assert_refused(self.detect(write(self.path("text.bag"), "text")), 2, "not a bag")
        self.assert_refused(self.detect(write(self.path("old.bag"), "#ROSBAG V1.2\n")), 2, "rosbag migrate")
        self.assert_refused(self.detect(write(self.path("no_table.db3"), b"SQLite format 3\0" + bytes(99))), 2,
                            "not a readable rosbag2 database")
        write(self.path("no_metadata/a.mcap"), read(self.run_mcap))
        self.assert_refused(self.detect(self.path("no_metadata")), 2, "no metadata.yaml", "pass its .mcap")
        write(self.path("photos/a.png"), png(IMAGES[0], SIZE))
        write(self.path("photos/a.mcap"), "")
        self.assert_done(self.detect(self.path("photos")))
        write(self.path("lost/b.mcap"), "")
        write(self.path("lost/metadata.yaml"), bag_files.metadata("a.mcap"))
        self.assert_refused(self.detect(self.path("lost")), 2, "lost/a.mcap: does not exist")
        result = run("detect", self.run_mcap, "--pattern", PATTERN, "-o", self.run_mcap)
        self.assert_refused(result, 7, "would overwrite the input")

    def test_topics_are_listed(self):
        info = Message("/info", bag_files.camera_info(stamp(0), SIZE, K, ()), stamp(0), INFO)
        path = write(self.path("list.mcap"), bag_files.mcap(messages() + [info]))
        result = run("bag", path, "--json")
        self.assert_done(result)
        topics = json.loads(result.stdout)["topics"]
        self.assertEqual([(row["topic"], row["type"], row["messages"]) for row in topics],
                         [(TOPIC, "sensor_msgs/Image", 4), ("/info", "sensor_msgs/CameraInfo", 1)])
        self.assertAlmostEqual(topics[0]["rate_hz"], 10, 6)
        self.assertEqual(topics[0]["bytes"], sum(len(message.data) for message in messages()))
        self.assertRegex(run("bag", path).stdout, r"MCAP, 5 messages in 0\.300 s\n"
                                                  r"(.*\n)*/cam0/image_raw +sensor_msgs/Image +4 +10 Hz")

    def test_camera_info_is_a_camera(self):
        d = (-0.2, 0.05, 1e-3, -2e-3, 0.01)
        for encoding, write_bag in (("cdr", bag_files.mcap), ("ros1", bag_files.ros1)):
            info = [Message(f"/cam{k}/camera_info", bag_files.camera_info(stamp(k), SIZE, K, d, binning=2 * k,
                                                                          encoding=encoding), stamp(k), INFO, encoding)
                    for k in range(2)]
            bag = write(self.path("info." + encoding), write_bag(info))
            camera = self.path("camera.yaml")
            result = run("import", bag, "--topic", "/cam0/camera_info", "-o", camera)
            self.assert_done(result)
            self.assertEqual(result.stderr, "")
            text = read(camera).decode()
            for key, value in zip(("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"), (K[0], K[4], K[2], K[5], *d)):
                self.assertEqual(float(re.search(rf"\b{key}: (\S+)", text)[1]), value)
            result = run("compare", bag + ":/cam1/camera_info", camera, "--json")
            self.assert_done(result)
            self.assertLess(json.loads(result.stdout)["max_px"], 1e-9)
            self.assertIn("binning and region of interest are ignored", result.stderr)
            self.assert_refused(run("import", bag, "--topic", "/cam2/camera_info", "-o", camera), 1,
                                "/cam0/camera_info, /cam1/camera_info")

    def test_a_rig_pairs_frames_by_stamp(self):
        write(self.path("lens.yaml"), LENS)
        pose = "rotation: {w: 1, x: 0, y: 0, z: 0}\n      translation: {x: 0, y: 0, z: 0}\n"
        rig = write(self.path("rig.yaml"), "raygrid_rig: 1\ncameras:\n" + "".join(
            f'  "{one}":\n    file: "lens.yaml"\n    camera_from_rig:\n      {pose}' for one in ("left", "right")))
        bag = write(self.path("rig.mcap"), bag_files.mcap(messages()[1:] + messages(topic="/right", shift_ns=2000000)))

        def localize(*options, right=":/right"):
            return run("localize", rig, "--camera", f"left={bag}:{TOPIC}", "--camera", "right=" + bag + right,
                       "--pattern", PATTERN, "-o", self.path("poses"), *options)
        result = localize()
        self.assert_done(result)
        self.assertIn("paired 3 frames, whose stamps differ by up to 2 ms; images without a partner: 1 of right",
                      result.stderr)
        rows = list(csv.DictReader(io.StringIO(read(self.path("poses/poses.csv")).decode())))
        self.assertEqual(sorted(row["image"] for row in rows), [name(0)[:-9] + "002000000", *map(name, (1, 2, 3))])
        self.assert_done(localize("--every", 2))
        self.assert_refused(localize("--sync-tolerance-s", 0.001), 2, "none of its", "--stamps log")
        self.assert_done(localize("--sync-tolerance-s", 0.001, "--stamps", "log"))
        self.assert_refused(localize(right=":" + TOPIC), 1, "same topic as camera left")
        self.assert_refused(localize("--sync-by", "number"), 1, "matched by their stamps")

    def test_undistorted_images_become_a_bag(self):
        camera = write(self.path("opencv.yaml"), LENS)
        out = self.path("rectified.mcap")
        self.assert_done(run("undistort", camera, self.run_mcap, "-o", out, "--threads", 1))
        first = read(out)
        self.assert_done(run("undistort", camera, self.run_mcap, "-o", out, "--threads", 2))
        self.assertEqual(read(out), first)
        topics = json.loads(run("bag", out, "--json").stdout)
        self.assertEqual(topics["remarks"], [])
        self.assertEqual([(row["topic"], row["messages"]) for row in topics["topics"]],
                         [("/cam0/camera_info", 4), ("/cam0/image_rect", 4)])
        self.assertEqual(self.images_of(out), list(map(name, range(4))))
        self.assert_done(run("undistort", camera, self.path("images"), "-o", self.path("flat")))
        result = run("compare", out, self.path("flat/view.camera.yaml"), "--json")
        self.assert_done(result)
        self.assertLess(json.loads(result.stdout)["max_px"], 1e-9)
        self.assert_done(run("undistort", camera, self.run_mcap, "-o", self.path("flat2")))
        self.assertEqual(read(self.path(f"flat2/{name(2)}.png")), read(self.path(f"flat/{name(2)}.png")))
        self.assert_refused(run("undistort", camera, self.run_mcap, "-o", self.run_mcap), 7, "would overwrite")
        self.assert_refused(run("undistort", camera, self.path("images"), "-o", out), 1, "messages need stamps")
        self.assert_refused(run("undistort", camera, self.run_mcap, "-o", self.path("no/folder/a.mcap")), 7, "a.mcap")
        self.assertEqual(read(out), first)
        self.assertEqual([name for name in os.listdir(self.folder) if ".part" in name], [])

    def test_a_rig_is_exported_as_camera_info(self):
        write(self.path("opencv.yaml"), LENS)
        rig = write(self.path("poses.yaml"), "raygrid_rig: 1\ncameras:\n" + "".join(
            f'  "{one}":\n    file: "opencv.yaml"\n    camera_from_rig:\n      rotation: {{w: 1, x: 0, y: 0, z: 0}}\n'
            f"      translation: {{x: {x}, y: 0, z: 0}}\n" for one, x in (("left", 0), ("right", -0.1))))
        out = self.path("rig_info.mcap")
        result = run("export", rig, "--to", "ros", "-o", out)
        self.assert_done(result)
        self.assertNotIn("not written", result.stderr)
        self.assertEqual([row["topic"] for row in json.loads(run("bag", out, "--json").stdout)["topics"]],
                         ["/left/camera_info", "/right/camera_info", "/tf_static"])
        result = run("compare", out + ":/right/camera_info", self.path("opencv.yaml"), "--json")
        self.assert_done(result)
        self.assertLess(json.loads(result.stdout)["max_px"], 1e-9)
        python = programs.long and peers()
        if python:
            found = json.loads(subprocess.run([python, os.path.join(HERE, "bags_peer.py"), "read", out], check=True,
                                              capture_output=True).stdout)
            self.assertEqual(found[1]["k"], [150.0, 0.0, 79.5, 0.0, 151.0, 59.5, 0.0, 0.0, 1.0])
            self.assertEqual(found[2]["transforms"], [["rig", "left", [0, 0, 0]], ["rig", "right", [0.1, 0, 0]]])

    @long_test
    def test_bags_of_other_programs_are_read(self):
        python = peers()
        if not python:
            self.skipTest("rosbags and mcap cannot be installed from PyPI")
        import numpy
        numpy.save(self.path("images.npy"), numpy.array([list(pixels) for pixels in IMAGES], numpy.uint8).reshape(
            len(IMAGES), SIZE[1], SIZE[0]))
        os.makedirs(self.path("peers"))
        subprocess.run([python, os.path.join(HERE, "bags_peer.py"), "write", self.path("images.npy"),
                        self.path("peers")], check=True)
        bags = sorted(os.listdir(self.path("peers")))
        self.assertEqual(len(bags), 14)
        for bag in bags:
            self.assertEqual(self.assert_same_features(self.path("peers/" + bag)).stderr, "", bag)
        self.assert_done(run("import", self.path("peers/foxglove.mcap"), "-o", self.path("foxglove.yaml")))
        self.assertRegex(read(self.path("foxglove.yaml")).decode(), r"fx: 9\n  fy: 8\n  cx: 7\n  cy: 6\n  k1: 0.1\n")
        self.assert_done(run("undistort", write(self.path("opencv.yaml"), LENS), self.run_mcap, "-o",
                             self.path("out.mcap")))
        found = json.loads(subprocess.run([python, os.path.join(HERE, "bags_peer.py"), "read", self.path("out.mcap")],
                                          check=True, capture_output=True).stdout)
        self.assertEqual([(row["stamp_ns"], row["log_ns"]) for row in found],
                         [(stamp(k), stamp(k) + 1000) for k in range(4) for _ in range(2)])
        self.assertEqual([row["encoding"] for row in found[1::2]], ["mono8"] * 4)


if __name__ == "__main__":
    main(__name__)
