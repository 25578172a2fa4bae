#!/usr/bin/env python3
"""Exports of bytes and pixels: compilers, objcopy and numpy read what raygrid wrote."""
import json
import os
import re
import shutil
import subprocess
import unittest
import zlib

from command_test import CommandTest, main, read, run, write

HOST_COMPILERS = [words for words in (("gcc", "c", "c99"), ("gcc", "c++", "c++98"),
                                      ("clang-14", "c", "c17")) if shutil.which(words[0])]
BOARD_COMPILERS = [name for name in ("arm-none-eabi-gcc",) if shutil.which(name)]
WARNINGS = ("-Wall", "-Wextra", "-pedantic", "-Werror")

PROGRAM = """#include "front.h"
#include "front.h"
#include <stdio.h>
int main(void) {
  if ((uintptr_t)front_raygrid % 4 != 0) return 1;
  if (sizeof(front_raygrid) != FRONT_RAYGRID_SIZE) return 2;
  printf("%lu %d %d ", (unsigned long)FRONT_RAYGRID_CRC32, FRONT_RAYGRID_WIDTH,
         FRONT_RAYGRID_HEIGHT);
  fwrite(front_raygrid, 1, FRONT_RAYGRID_SIZE, stdout);
  return 0;
}
"""


class TableTest(CommandTest):
    def export(self, camera, *arguments, out):
        result = run("export", camera, *arguments, "--json", "-o", self.path(out))
        self.assert_done(result)
        return json.loads(result.stdout)

    def done(self, *command):
        result = subprocess.run(command, capture_output=True, check=False, cwd=self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout


class Blobs(TableTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        camera = cls.simulated_camera("wide")
        text = re.sub("^(name|serial): .*\n", "", read(camera).decode(), flags=re.MULTILINE)
        cls.camera = write(cls.path("named.yaml"),
                           'name: "left */ /* ??/ \\u00e9"\nserial: "*/ 1"\n' + text)
        cls.blob = cls.path("front.raygrid")
        result = run("pack", cls.camera, "--remap", "160x120", "-o", cls.blob)
        assert result.returncode == 0, result.stderr
        cls.bytes = read(cls.blob)

    def check_program(self, folder):
        """In both languages and with each compiler the array is the blob, and is aligned."""
        sources = [source for source in ("front.c",) if os.path.exists(f"{folder}/{source}")]
        write(f"{folder}/main.c", PROGRAM)
        for compiler, language, standard in HOST_COMPILERS:
            with self.subTest(compiler=compiler, standard=standard):
                objects = []
                for source in sources:
                    objects.append(f"{folder}/front.o")
                    self.done(compiler, "-std=c99", *WARNINGS, "-c", f"{folder}/{source}", "-o",
                              objects[-1])
                self.done(compiler, *WARNINGS, "-std=" + standard, "-x", language,
                          f"{folder}/main.c", "-x", "none", *objects, "-o", f"{folder}/main")
                head, _, rest = self.done(f"{folder}/main").partition(b" 160 120 ")
                self.assertEqual(int(head), zlib.crc32(self.bytes))
                self.assertTrue(rest == self.bytes)
        for compiler in BOARD_COMPILERS:
            self.done(compiler, "-std=c99", *WARNINGS, "-ffreestanding", "-c", "-x", "c",
                      f"{folder}/{(sources or ['front.h'])[0]}", "-o", f"{folder}/board.o")

    def test_compilers_find_the_blob_in_the_array(self):
        told = self.export(self.blob, "--to", "c", out="one/front.h")
        self.assertEqual((told["files"], told["bytes"], told["crc32"]),
                         ([self.path("one/front.h")], len(self.bytes), zlib.crc32(self.bytes)))
        told = self.export(self.blob, "--to", "c", out="two/front.c")
        self.assertEqual(told["files"], [self.path("two/front.c"), self.path("two/front.h")])
        for folder in ("one", "two"):
            self.check_program(self.path(folder))

    def test_the_name_is_one_that_c_knows(self):
        for file, name in (("int.h", "int_raygrid"), ("4 left-1.h", "camera_4_left_1_raygrid"),
                           ("_\u00e9.h", "camera_raygrid"), ("a--b_.h", "a_b_raygrid")):
            self.export(self.blob, "--to", "c", out=file)
            self.assertTrue(f"const uint8_t {name}[" in read(self.path(file)).decode())
            self.done("gcc", "-std=c99", *WARNINGS, "-fsyntax-only", "-x", "c", self.path(file))

    def test_objcopy_finds_the_blob_in_intel_hex(self):
        """Also where it begins within a line, and where it crosses a border of 64 KiB."""
        for address in (0, 0x08080000, 0x0800FFF4, 2**32 - len(self.bytes)):
            with self.subTest(hex(address)):
                self.export(self.blob, "--to", "hex", "--address", hex(address), out="front.hex")
                self.done("objcopy", "-I", "ihex", "-O", "binary", "front.hex", "back.bin")
                self.assertTrue(read(self.path("back.bin")) == self.bytes)
                self.done("objcopy", "-I", "ihex", "-O", "srec", "front.hex", "back.srec")
                first = re.search(rb"^S(\d)..([0-9A-F]*)", read(self.path("back.srec")).replace(
                    b"S0", b"x"), re.MULTILINE)
                digits = {b"1": 4, b"2": 6, b"3": 8}[first[1]]
                self.assertEqual(int(first[2][:digits], 16), address)

    def test_objcopy_finds_a_wrong_byte(self):
        self.export(self.blob, "--to", "hex", "--address", 0, out="front.hex")
        text = read(self.path("front.hex")).decode().splitlines()
        text[2] = text[2][:9] + f"{int(text[2][9:11], 16) ^ 1:02X}" + text[2][11:]
        write(self.path("mutant.hex"), "\n".join(text) + "\n")
        result = subprocess.run(["objcopy", "-I", "ihex", "-O", "binary", self.path("mutant.hex"),
                                 self.path("mutant.bin")], capture_output=True, check=False)
        self.assertNotEqual(result.returncode, 0)

    def test_what_cannot_be(self):
        def refused(camera, code, *words, to, out="never/x.h", more=()):
            with self.subTest((to, more)):
                self.assert_refused(run("export", camera, "--to", to, *more, "-o",
                                        self.path(out)), code, *words)
        refused(self.camera, 2, "named.yaml", "no blob", "raygrid pack", to="c")
        refused(self.blob, 1, "x.txt", "front.h", "front.c", to="c", out="never/x.txt")
        refused(self.blob, 1, "--address", "0x08080000", to="hex")
        for address, words in (("0x08080002", ("multiples of 4",)), ("0xfffffffc", ("32 bits",)),
                               ("0x100000000", ("32 bits",)), ("-4", ("number",)),
                               ("12q", ("number",)), ("0x", ("number",))):
            refused(self.blob, 1, "--address", *words, to="hex", more=("--address=" + address,))
        for option, value in (("--address", "4"), ("--model", "x"), ("--hfov", "60"),
                              ("--max-fit-error", "1"), ("--poses", "p.csv")):
            refused(self.blob, 1, option, "--to c does not take it", to="c", more=(option, value))
        refused(self.blob, 1, "--rectified", "hex", to="hex",
                more=("--rectified", "--address", "4"))
        refused(self.camera, 1, "--address", "ros", to="ros", more=("--address", "4"))
        refused(self.blob, 1, "--to bin", "opencv", "c", "hex", to="bin")
        broken = write(self.path("broken.raygrid"), self.bytes[:-9] + b"x" + self.bytes[-8:])
        refused(broken, 8, "broken.raygrid", to="c")
        self.assert_nothing_in(self.path("never"))
        write(self.path("own.h"), self.bytes)
        self.assert_refused(run("export", self.path("own.h"), "--to", "c", "-o",
                                self.path("own.c")), 7, "replace the input")

    def test_all_are_listed(self):
        listed = {entry["name"]: entry for entry in
                  json.loads(run("export", "--list", "--json").stdout)}
        self.assertEqual((listed["c"]["of"], listed["hex"]["options"]), ("a blob", ["address"]))
        text = run("export", "--list").stdout
        for entry in listed.values():
            self.assertIn(entry["name"] + ": " + entry["holds"], text)


if __name__ == "__main__":
    main(__name__)
