#!/usr/bin/env python3
"""update keeps two blobs for a device: a run that is cut leaves the one that was there."""
import json
import os
import resource
import struct
import subprocess
import zlib

from command_test import CommandTest, main, programs, read, run, write

SLOT = 32768


def read_slot(data):
    """Sequence and blob of a slot, by formats/SPEC.md; None if it is not valid."""
    magic, major, offset, sequence, size, crc = struct.unpack_from("<8sHHIII", data)
    header_crc, = struct.unpack_from("<I", data, 60)
    blob = data[64:64 + size]
    valid = (magic == b"RGSLOTS\0" and (major, offset) == (1, 64) and zlib.crc32(data[:60]) == header_crc
             and 1 <= size <= len(data) - 64 and zlib.crc32(blob) == crc)
    return (sequence, blob) if valid else None


def newest(data):
    """Index, sequence and blob of the newest slot."""
    half = len(data) // 2
    slots = [read_slot(data[:half]), read_slot(data[half:])]
    valid = [(k, *slot) for k, slot in enumerate(slots) if slot]
    if len(valid) == 2:
        ahead = (valid[1][1] - valid[0][1]) % 2 ** 32
        return valid[1 if 1 <= ahead < 2 ** 31 else 0]
    return valid[0] if valid else None


class Update(CommandTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        camera = cls.simulated_camera("wide")
        for name, more in (("a", ()), ("b", ("--remap", "160x120,hfov=60")), ("c", ("--serial", "c"))):
            cls.succeed("pack", camera, *more, "-o", cls.path(name + ".raygrid"))
        cls.blobs = {name: read(cls.path(name + ".raygrid")) for name in "abc"}

    def setUp(self):
        self.slots = os.path.join(self.folder, self.id().split(".")[-1], "slots.bin")

    def update(self, name, *more, **options):
        return run("update", self.path(name + ".raygrid"), "--slots", self.slots, *more, **options)

    def check_newest(self, index, sequence, name):
        self.assertEqual(newest(read(self.slots)), (index, sequence, self.blobs[name]))

    def test_a_block_device_is_inspected_by_the_size_of_its_slots(self):
        self.assert_done(self.update("a", "--slot-size", "32K"))
        with open(self.slots, "ab") as file:
            file.write(bytes(3 * SLOT))  # a device is larger than its slots
        attached = subprocess.run(["losetup", "--find", "--show", self.slots], check=False,
                                  capture_output=True, text=True)
        if attached.returncode != 0:
            self.skipTest("no block device to write to: losetup attaches none here, "
                          "as in containers and without root")
        device = attached.stdout.strip()
        try:
            self.succeed("update", self.path("b.raygrid"), "--slots", device,
                         "--slot-size", "32K")
            result = self.succeed("inspect", device, "--slot-size", "32K", "--json")
            self.assertEqual(json.loads(result.stdout)["newest"], 1)
            self.assert_refused(run("inspect", device), 1, "--slot-size")
            self.assert_refused(run("inspect", device, "--slot-size", "1M"), 2, "smaller --slot-size")
        finally:
            subprocess.run(["losetup", "--detach", device], check=True)

    def test_slots_take_turns_and_the_other_one_stays(self):
        self.assert_done(self.update("a", "--slot-size", "32K"))
        self.assertEqual(os.path.getsize(self.slots), 2 * SLOT)
        self.check_newest(0, 1, "a")
        for turn, name in enumerate("bcab"):
            before = read(self.slots)
            result = self.update(name, "--json")
            self.assert_done(result)
            told = json.loads(result.stdout)
            index = 1 - turn % 2
            self.assertEqual((told["slot"], told["sequence"], told["written"]), (index, turn + 2, True))
            self.check_newest(index, turn + 2, name)
            kept = slice(SLOT, None) if index == 0 else slice(SLOT)
            self.assertEqual(read(self.slots)[kept], before[kept])

    def test_the_newest_blob_is_not_written_again(self):
        for name in ("a", "b"):
            self.assert_done(self.update(name, "--slot-size", SLOT))
        before = read(self.slots)
        result = self.update("b")
        self.assert_done(result)
        self.assertIn("already", result.stdout)
        self.assertEqual(read(self.slots), before)

    def test_a_run_that_is_cut_leaves_the_newest_blob(self):
        """At a byte of the second slot no more can be written."""
        for name in "abc":  # the newest one in the first slot, an older one in the second
            self.assert_done(self.update(name, "--slot-size", SLOT))
        before = read(self.slots)
        for limit in [*range(SLOT + 1, SLOT + 66, 8), SLOT + 500, 2 * SLOT - 1]:
            write(self.slots, before)

            def limit_size(limit=limit):
                resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
            result = subprocess.run([programs.raygrid, "update", self.path("a.raygrid"), "--slots", self.slots],
                                    preexec_fn=limit_size, capture_output=True, text=True, check=False)
            self.assert_refused(result, 7, "slots.bin")
            self.assertNotEqual(read(self.slots), before)
            self.check_newest(0, 3, "c")
            self.assert_done(self.update("a"))
            self.check_newest(1, 4, "a")

    def test_sequence_wraps_around(self):
        self.assert_done(self.update("a", "--slot-size", SLOT))
        slots = bytearray(read(self.slots))
        struct.pack_into("<I", slots, 12, 2 ** 32 - 1)
        struct.pack_into("<I", slots, 60, zlib.crc32(slots[:60]))
        write(self.slots, bytes(slots))
        self.assert_done(self.update("b"))
        self.check_newest(1, 0, "b")

    def test_a_damaged_slot_is_written_next(self):
        for name in "ab":
            self.assert_done(self.update(name, "--slot-size", SLOT))
        slots = bytearray(read(self.slots))
        slots[SLOT + 100] ^= 1
        write(self.slots, bytes(slots))
        self.check_newest(0, 1, "a")
        facts = json.loads(run("inspect", self.slots, "--json").stdout)
        self.assertEqual(facts["newest"], 0)
        self.assertEqual(facts["slot_0"]["bytes"], len(self.blobs["a"]))
        self.assertEqual(facts["slot_0"]["image_size"], [160, 120])
        self.assertEqual(facts["slot_1"]["state"], "incomplete")
        self.assert_done(self.update("c"))
        self.check_newest(1, 2, "c")
        slots[100] ^= 1
        write(self.slots, bytes(slots))
        refused = run("inspect", self.slots)
        self.assert_refused(refused, 8, "neither slot")
        self.assertIn("incomplete", refused.stdout)

    def put(self, index, sequence, blob):
        """What a program writes that does not look at the blob: its CRCs are right."""
        header = struct.pack("<8sHHIII36x", b"RGSLOTS\0", 1, 64, sequence, len(blob), zlib.crc32(blob))
        slots = bytearray(read(self.slots))
        begin = index * SLOT
        slots[begin:begin + SLOT] = (header + struct.pack("<I", zlib.crc32(header)) + blob).ljust(SLOT, b"\xff")
        write(self.slots, bytes(slots))

    def test_a_blob_that_does_not_open_is_written_over_first(self):
        later = bytearray(self.blobs["b"])
        later[8] += 1  # the major version
        for bad in (bytes(later), b"damaged", self.blobs["b"][:200], bytes(3000)):
            for newest_slot in (0, 1):
                write(self.slots, b"\xff" * 2 * SLOT)
                self.put(1 - newest_slot, 4, self.blobs["a"])
                self.put(newest_slot, 5, bad)
                told = self.succeed("inspect", self.slots, "--json")
                facts = json.loads(told.stdout)
                self.assertEqual(facts["newest"], 1 - newest_slot)
                self.assertEqual(facts[f"slot_{newest_slot}"]["state"], "unreadable")
                self.assertEqual(facts[f"slot_{newest_slot}"]["bytes"], len(bad))
                self.assertEqual(facts[f"slot_{1 - newest_slot}"]["state"], "valid")
                self.assert_done(self.update("c"))
                self.check_newest(newest_slot, 5, "c")
        for index in (0, 1):
            self.put(index, 4 + index, b"damaged")
        refused = run("inspect", self.slots)
        self.assert_refused(refused, 8, "neither slot")
        self.assertEqual(refused.stdout.count("unreadable"), 2)
        self.assert_done(self.update("c"))
        self.check_newest(0, 6, "c")

    def test_a_camera_may_have_the_name_of_slots(self):
        lines = read(self.path("sim_wide/true_camera.yaml")).splitlines()
        lines = [line for line in lines if not line.startswith(b"name:")] + [b"name: RGSLOTS", b""]
        camera = write(self.path("named.yaml"), b"\n".join(lines))
        self.succeed("pack", camera, "--serial", "RGSLOTS", "-o", self.path("named.raygrid"))
        for name in ("named", "named", "a", "named"):
            self.assert_done(self.update(name, "--slot-size", SLOT))
        self.assertEqual(json.loads(run("inspect", self.slots, "--json").stdout)["newest"], 0)

    def test_what_cannot_be_is_refused_and_nothing_is_written(self):
        damaged = write(self.path("damaged.raygrid"), self.blobs["a"][:-4] + b"abcd")
        self.assert_refused(run("update", damaged, "--slots", self.slots), 8, "damaged.raygrid")
        self.assert_refused(self.update("b", "--slot-size", 1024), 7, "b.raygrid", "--slot-size")
        self.assert_refused(self.update("b", "--slot-size", 32770), 1, "--slot-size")
        self.assertFalse(os.path.exists(self.slots))
        blob = self.path("a.raygrid")
        self.assert_refused(run("update", blob, "--slots", blob), 7, "overwrite the input")
        photo = write(self.path("photo.bin"), bytes(range(256)) * 256)
        self.assert_refused(run("update", blob, "--slots", photo), 2, "--initialize")
        self.assert_refused(run("update", blob, "--slots", photo, "--slot-size", "4K"), 2, "65536 bytes")
        # A copy of flash with more behind the slots, or with less.
        two = self.path("two.bin")
        self.succeed("update", blob, "--slots", two)
        self.succeed("update", self.path("b.raygrid"), "--slots", two)
        whole = read(two)
        for copy in (whole + bytes(1000), whole[:100000]):
            place = write(self.path("copy.bin"), copy)
            self.assert_refused(run("update", blob, "--slots", place), 2, "found a slot at byte 65536")
            self.assertEqual(read(place), copy)
        self.assertEqual(read(photo), bytes(range(256)) * 256)
        self.succeed("update", blob, "--slots", photo, "--initialize")
        self.assertEqual(newest(read(photo)), (0, 1, self.blobs["a"]))
        self.assert_refused(run("update", blob, "--slots", "/dev/null"), 7, "/dev/null")
        self.assert_refused(run("update", blob, "--slots", self.folder), 7, "cannot be written")
        self.assert_refused(run("update", blob, "--slots", write(self.path("empty.bin"), b"")), 7,
                            "a slot has 0")


if __name__ == "__main__":
    main(__name__)
