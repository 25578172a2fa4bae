"""Helpers of the command tests: running a program, and a few files to run it on."""
import argparse
import functools
import os
import re
import resource
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "support"))
import json_schemas

programs = argparse.Namespace()

PATTERN = """raygrid_pattern: 1
boards:
  - {id: 0, kind: chessboard, columns: 9, rows: 6, square_m: 0.025}
"""

# More corners than PATTERN's, fewer than those of simulate's own board, which take longer.
SIMULATED_PATTERN = """raygrid_pattern: 1
boards:
  - {id: 0, kind: chessboard, columns: 14, rows: 10, square_m: 0.03}
"""

# A program that takes longer hangs. No test depends on how busy the machine is: limits are in
# CPU time.
HANG_S = 600

HERE = os.path.dirname(os.path.abspath(__file__))


def python_with(*modules):
    """A Python that has the modules: this one, or Debian's; or None."""
    pythons = (sys.executable, "/usr/bin/python3")
    return next((python for python in pythons if subprocess.run(
        [python, "-c", f"import {', '.join(modules)}"], capture_output=True, check=False).returncode == 0), None)


NO_OPENCV = "no Python has cv2; 'tools/install_packages tests' installs it"
cache = tempfile.TemporaryDirectory()


def main(module):
    """Reads where the programs are, and runs the module's tests."""
    parser = argparse.ArgumentParser()
    for name in ("raygrid", "undistort", "reference", "photographs"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--long", action="store_true", help="with the tests that take minutes")
    # A shell ignores it in what it starts in the background, and programs inherit that.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # Nothing that other versions of the programs remember.
    os.environ["XDG_CACHE_HOME"] = cache.name
    _, rest = parser.parse_known_args(namespace=programs)
    unittest.main(module=module, argv=[module] + rest, verbosity=2)


def long_test(method):
    """Marks a test that only tests/run everything runs."""
    @functools.wraps(method)
    def wrapper(self):
        if not programs.long:
            self.skipTest("takes minutes; tests/run everything runs it")
        method(self)
    return wrapper


def run(*arguments, program=None):
    """Runs raygrid, or another program, without a terminal. What raygrid says in JSON is to be as
    the schemas say."""
    command = [program or programs.raygrid, *map(str, arguments)]
    start = time.time()
    result = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL,
                            timeout=HANG_S, check=False)
    # What ended with an error may have met files that a test damaged.
    if arguments and not program and result.returncode in (0, 5, 6):
        check_json(list(map(str, arguments)), result.stdout, start)
    return result


def commands(*path):
    """The commands that raygrid, or one of its commands, lists."""
    return re.findall(r"^  ([a-z-]+)  ", run(*path, "--help").stdout.split("\nOptions:")[0], re.MULTILINE)


def specifications():
    """A target of each kind."""
    return re.findall(r"^  ([a-z]+:\S+)", run("pattern", "--help").stdout, re.MULTILINE)


def call(value, *path):
    """A command with what its help requires: arguments, which are in capitals, and options. value: the word for a name;
    None if there is none for one of them."""
    text = run(*path, "--help").stdout
    names = re.findall(r" ([A-Z]+)\b", re.search(r"^Usage:.*\[OPTIONS\](.*)", text, re.MULTILINE)[1])
    names += re.findall(r"^  (?:-\w,)?(--[\w-]+) (?:.*\n {26})*.*\(required\)", text, re.MULTILINE)
    words = [*path, *(word for name in names for word in (name, value(name))[name.isupper():])]
    return None if None in words else words


def check_json(arguments, stdout, start):
    """Checks what a command printed with --json, and the files that it wrote."""
    if "--json" in arguments and stdout[:1] in ("{", "["):
        json_schemas.check_output(arguments, stdout)
    if arguments[0] not in ("batch", "calibrate", "capture", "compare"):
        return
    outputs = [after for option, after in zip(arguments, arguments[1:]) if option in ("-o", "--output")]
    for output in outputs:
        for folder, _, names in os.walk(output):
            for path in (os.path.join(folder, name) for name in names if json_schemas.has_schema(name)):
                # Times of files are coarser than the clock.
                if os.path.getmtime(path) > start - 0.1:
                    json_schemas.check_file(path)


def cpu_seconds(pid):
    """The CPU time of a running process."""
    fields = read(f"/proc/{pid}/stat").decode().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def cpu_seconds_of_children():
    """The CPU time of programs that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def write(path, contents):
    mode = "wb" if isinstance(contents, bytes) else "w"
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, mode) as file:
        file.write(contents)
    return path


def read(path):
    with open(path, "rb") as file:
        return file.read()


def with_word(blob, kind, offset, value):
    """The blob with a word of its sections of a kind, and CRCs that hold."""
    blob = bytearray(blob)
    count = struct.unpack_from("<H", blob, 16)[0]
    for entry in range(32, 32 + 16 * count, 16):
        found, _, section, size = struct.unpack_from("<HHII", blob, entry)
        if found == kind:
            struct.pack_into("<I", blob, section + offset, value)
            struct.pack_into("<I", blob, entry + 12, zlib.crc32(blob[section:section + size]))
    struct.pack_into("<I", blob, 28, zlib.crc32(blob[32:32 + 16 * count], zlib.crc32(blob[:28])))
    return bytes(blob)


def wait_until(is_so, poll_s=0.01):
    """Waits for what is to come, and returns it. Fails if it does not come."""
    end = time.monotonic() + HANG_S
    while True:
        value = is_so()
        if value:
            return value
        assert time.monotonic() < end, "it did not come in time"
        time.sleep(poll_s)


class CommandTest(unittest.TestCase):
    """A folder of its own for each class of tests, and checks of a finished run."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = cls.temporary.name

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder, name)

    @classmethod
    def simulated_camera(cls, lens, size="160x120"):
        """The file of a lens that is known exactly."""
        board = write(cls.path("board.yaml"), SIMULATED_PATTERN)
        cls.succeed("simulate", "--images", 1, "--lens", lens, "--size", size, "--pattern", board,
                    "-o", cls.path(f"sim_{lens}"))
        return cls.path(f"sim_{lens}/true_camera.yaml")

    @classmethod
    def succeed(cls, *arguments, **options):
        """Runs raygrid, which has to succeed, and returns the result."""
        result = run(*arguments, **options)
        assert result.returncode == 0, result.stderr
        return result

    def assert_done(self, result):
        self.assertEqual(result.returncode, 0, result.stderr)

    def assert_refused(self, result, code, *words):
        """One line on stderr that says what is wrong, and the code that goes with it."""
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        lines = result.stderr.strip().splitlines()
        self.assertEqual(len(lines), 1, result.stderr)
        for word in words:
            self.assertIn(word, lines[0])

    def assert_nothing_in(self, folder):
        left = os.listdir(folder) if os.path.isdir(folder) else []
        self.assertEqual(left, [])


class CalibratedTest(CommandTest):
    """A simulated camera and its results."""
    options = ()

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for arguments in (
                ("simulate", "--images", 12, "--features-per-image", 120, "--pattern",
                 write(cls.path("board.yaml"), SIMULATED_PATTERN), "-o", cls.path("sim")),
                ("calibrate", "--features", cls.path("sim/features.csv"), "--image-size",
                 "640x480", "--pattern", cls.path("sim/pattern.yaml"), "--knot-spacing-px", 80, "-o",
                 cls.path("out"), "--name", "front", *cls.options)):
            cls.succeed(*arguments)
