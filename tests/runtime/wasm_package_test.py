#!/usr/bin/env python3
"""The npm package as npm packs it: its files, types and version, and wasm_package_test.mjs.

    wasm_package_test.py VERSION    the project's
"""
import json
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SOURCE = ROOT / "runtime" / "wasm"
VERSION = sys.argv[1]


def pack(folder):
    """The package's folder, as users get it."""
    if shutil.which("npm"):
        subprocess.run(["npm", "pack", "--offline", "--silent", "--pack-destination", folder, SOURCE],
                       check=True, capture_output=True, cwd=folder)
        (archive,) = Path(folder).glob("*.tgz")
        with tarfile.open(archive) as tar:
            tar.extractall(folder)
        return Path(folder) / "package"
    package = Path(folder) / "package"
    package.mkdir()
    for name in ("package.json", *json.loads((SOURCE / "package.json").read_text())["files"]):
        shutil.copy(SOURCE / name, package)
    return package


class WasmPackage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.package = pack(folder.name)

    def test_module_is_that_of_the_sources(self):
        if not (shutil.which("clang-14") and shutil.which("wasm-ld-14")):
            self.skipTest("no clang-14 or lld-14; tools/install_packages tests installs them")
        done = subprocess.run([SOURCE / "build", "--check"], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_version_is_the_projects(self):
        self.assertEqual(json.loads((self.package / "package.json").read_text())["version"], VERSION)

    def test_types_have_the_names_of_the_code(self):
        code = (self.package / "raygrid.js").read_text()
        types = (self.package / "raygrid.d.ts").read_text()
        exported = re.findall(r"^export (?:async )?(?:const|function|class) (\w+)", code, re.M)
        self.assertGreater(len(exported), 5)
        typed = re.findall(r"^export (?:const|function|class) (\w+)", types, re.M)
        self.assertEqual(sorted(exported), sorted(typed))
        body = code.split("export class Camera {")[1]
        members = set(re.findall(r"^  (?:get )?([a-z]\w*)\(", body, re.M)) - {"constructor"}
        typed = re.findall(r"^  (?:readonly )?([a-z]\w*)[(:<]",
                           types.split("export class Camera {")[1], re.M)
        self.assertEqual(members, set(typed) - {"constructor"})

    def test_golden_blobs(self):
        if not shutil.which("node"):
            self.skipTest("no node; tools/install_packages tests installs it")
        with tempfile.TemporaryDirectory() as folder:
            header = Path(folder, "golden_blobs.h")
            subprocess.run([sys.executable, "-B", ROOT / "tests/golden/make_golden.py", header], check=True)
            done = subprocess.run(["node", HERE / "wasm_package_test.mjs", header, self.package],
                                  capture_output=True, text=True, check=False)
        print(*re.findall(r"^(?:remap CRC \w+|k\w+ .* px|.*are opened)$", done.stdout, re.M), sep="\n")
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
