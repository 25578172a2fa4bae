#!/usr/bin/env python3
"""The API reference builds without warnings, and every public name has an entry.

    api_reference_test.py c
    api_reference_test.py python PACKAGES      the folder of the built Python package
"""
import ast
import importlib.util
import inspect
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zlib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MISSING = "no {}; tools/install_packages reference installs it"
PACKAGES = Path()


def build(part, folder, *more):
    done = subprocess.run([ROOT / "tools" / "api_reference" / "build", part, folder, *more], capture_output=True,
                          text=True, check=False)
    return done.returncode, done.stdout + done.stderr


@unittest.skipUnless(shutil.which("doxygen"), MISSING.format("doxygen"))
class CReference(unittest.TestCase):
    def test_every_exported_function_is_documented(self):
        with tempfile.TemporaryDirectory() as folder:
            status, output = build("c", Path(folder) / "html")
            self.assertEqual((status, output), (0, ""))
            tags = (Path(folder) / "html.tag").read_text(encoding="utf-8")
            pages = "".join(path.read_text(encoding="utf-8") for path in Path(folder).rglob("*.html"))
        documented = set(re.findall(r'<member kind="function">\s*<type>[^<]*</type>\s*<name>(\w+)', tags))
        symbols = (ROOT / "debian" / "libraygrid0.symbols").read_text(encoding="utf-8")
        self.assertEqual(documented, set(re.findall(r"^ (rg_\w+)@", symbols, re.MULTILINE)))
        self.assertNotIn("<script", pages)

    def test_the_cpp_library_is_documented(self):
        with tempfile.TemporaryDirectory() as folder:
            status, output = build("cpp", Path(folder) / "html")
            self.assertEqual((status, output), (0, ""))
            pages = {path.name: path.read_text(encoding="utf-8") for path in Path(folder).rglob("*.html")}
        for name in ("UnprojectLine", "ProjectAll", "SetParameters"):
            self.assertIn(name, pages["classraygrid_1_1Camera.html"])
        self.assertIn("LoadRig", pages["rig_8h.html"])
        self.assertNotIn("<script", "".join(pages.values()))

    def test_what_is_incomplete_is_an_error(self):
        settings = (ROOT / "tools" / "api_reference" / "Doxyfile").read_text(encoding="utf-8")
        for declaration in ("int rg_new(int size);",
                            "/** Counts.\n * @return a number */\nint rg_new(int size);",
                            "/** Counts.\n * @param size pixels */\nint rg_new(int size);",
                            "/** A size. */\ntypedef struct rg_size { int width; } rg_size;"):
            with self.subTest(declaration), tempfile.TemporaryDirectory() as folder:
                header = Path(folder) / "new.h"
                header.write_text("/** @file\n * New. */\n" + declaration + "\n", encoding="utf-8")
                done = subprocess.run(
                    ["doxygen", "-"], cwd=ROOT, capture_output=True, text=True, check=False,
                    input=f"{settings}\nINPUT = {header}\nOUTPUT_DIRECTORY = {folder}\n")
                self.assertNotEqual(done.returncode, 0)
                self.assertIn("not documented", done.stderr)


def public_names(module):
    """The names of a module, of its classes and of their members, by their full names."""
    listed = getattr(module, "__all__", None) or [
        name for name, value in vars(module).items()
        if not name.startswith("_") and not inspect.ismodule(value)
        and getattr(value, "__module__", module.__name__) == module.__name__]
    for name in listed:
        value = getattr(module, name)
        if inspect.ismodule(value):
            yield from public_names(value)
            continue
        yield f"{module.__name__}.{name}"
        if inspect.isclass(value) and not issubclass(value, Exception):
            for member in dir(value):
                if not member.startswith("_") and not (issubclass(value, tuple) and hasattr(tuple, member)):
                    yield f"{module.__name__}.{name}.{member}"


def stub_defaults():
    """Defaults of arguments, by the stub."""
    stub = ROOT / "offline" / "python" / "raygrid" / "_raygrid.pyi"
    found = set()
    for node in ast.walk(ast.parse(stub.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            of_all = node.args
            positional = of_all.args[len(of_all.args) - len(of_all.defaults):]
            found |= {(argument.arg, ast.unparse(value).replace("'", '"')) for argument, value in
                      zip(positional + of_all.kwonlyargs, of_all.defaults + of_all.kw_defaults) if value}
    return found


def bound_defaults():
    """Defaults of arguments, by the bindings."""
    of_python = {"py::none()": "None", "false": "False", "true": "True"}
    found = set()
    for path in (ROOT / "offline" / "python").glob("*_binding.cc"):
        for name, value in re.findall(r'py::arg\("(\w+)"\)\s*=\s*("[^"]*"|py::none\(\)|std::vector<[^()]*\(\)|[\w.]+)',
                                      path.read_text(encoding="utf-8")):
            found.add((name, "()" if value.startswith("std::vector") else of_python.get(value, value)))
    return found


class PythonReference(unittest.TestCase):
    def test_every_public_name_is_documented(self):
        if not importlib.util.find_spec("sphinx"):
            self.skipTest(MISSING.format("python3-sphinx"))
        if not list(PACKAGES.glob("raygrid/_raygrid.*.so")):
            self.skipTest(f"the Python package is not built in {PACKAGES}")
        with tempfile.TemporaryDirectory() as folder:
            status, output = build("python", folder, sys.executable, PACKAGES)
            self.assertEqual((status, output), (0, ""))
            inventory = (Path(folder) / "objects.inv").read_bytes().split(b"\n", 4)[4]
            pages = "".join(path.read_text(encoding="utf-8") for path in Path(folder).glob("*.html"))
        # Sphinx takes what is before a colon for a type, in an attribute's first line and in Returns.
        self.assertEqual(re.findall(r">Type<|<p><em>.*</em> –.*", pages), [])
        documented = {line.split()[0] for line in zlib.decompress(inventory).decode().splitlines()}
        sys.path.insert(0, str(PACKAGES))
        sys.dont_write_bytecode = True
        import raygrid
        from raygrid import _runtime
        names = set(public_names(raygrid))
        of_devices = {name.replace("raygrid._runtime", "raygrid_runtime") for name in public_names(_runtime)}
        self.assertGreater(min(len(names), len(of_devices)), 30)
        # Two names of one class have their members once.
        of_devices = {name for name in of_devices if not name.startswith("raygrid_runtime.Blob.")}
        self.assertEqual((names | of_devices) - documented, set())

    def test_defaults_of_the_stub_are_those_of_the_bindings(self):
        self.assertGreater(len(stub_defaults()), 25)
        self.assertEqual(stub_defaults(), bound_defaults())


if __name__ == "__main__":
    if sys.argv[1] == "python":
        PACKAGES = Path(sys.argv.pop()).resolve()
    del globals()[{"c": "PythonReference", "python": "CReference"}[sys.argv.pop()]]
    unittest.main()
