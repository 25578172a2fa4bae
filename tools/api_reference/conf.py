"""Sphinx's settings for the Python reference. The package is imported: PYTHONPATH leads to it."""
import ast
import importlib.util
import re
import sys
from pathlib import Path

import raygrid

PACKAGE = Path(raygrid.__file__).parent


def load_device_module():
    """The module for devices by the name that its wheel has; in the package it is _runtime.py."""
    spec = importlib.util.spec_from_file_location("raygrid_runtime", PACKAGE / "_runtime.py")
    sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[spec.name])


load_device_module()

project = "raygrid"
extensions = ["sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["c"]
html_theme = "alabaster"
html_theme_options = {"page_width": "64em", "show_powered_by": False}
html_sidebars = {"**": ["globaltoc.html", "searchbox.html"]}
html_show_copyright = html_show_sphinx = html_copy_source = html_domain_indices = False
autodoc_member_order = "bysource"
napoleon_use_rtype = False

# How the stub's names of types are shown.
SHOWN = {r"\b_Doubles\b": "NDArray[float64]", r"\b_Path\b": "str | PathLike", r"\b_Images\b": "Images",
         r"\b_Progress\b": "Callable", r"\b(npt|np|os)\.": "", r"\b_raygrid\.": "raygrid.",
         r"Literal\[False\] \| Literal\[True\]": "bool"}


def shown(*annotations):
    """The annotations of overloads as one text."""
    texts = [ast.unparse(annotation) for annotation in annotations if annotation]
    text = " | ".join(dict.fromkeys(texts))
    for pattern, replacement in SHOWN.items():
        text = re.sub(pattern, replacement, text)
    return text


def signature_of(functions):
    """Arguments and result of a function that is written several times, once for each overload."""
    for k, argument in enumerate(list_arguments(functions[0])):
        same = [list_arguments(function)[k].annotation for function in functions]
        text = shown(*same)
        argument.annotation = ast.Name(text) if text else None
    arguments = functions[0].args
    if arguments.args and arguments.args[0].arg == "self":
        del arguments.args[0]
    return f"({ast.unparse(arguments)})", shown(*(function.returns for function in functions))


def list_arguments(function):
    return [*function.args.args, *function.args.kwonlyargs]


def read_signatures():
    """(arguments, result) by qualified name, as the stub and the modules write them: an extension
    has none, and evaluated types are longer."""
    functions = {}
    for file in ("_raygrid.pyi", "_blob.py", "_rig.py", "importers.py"):
        prefix = "raygrid.importers" if file == "importers.py" else "raygrid"
        module = ast.parse((PACKAGE / file).read_text(encoding="utf-8"))
        scopes = [(prefix, module)] + [(f"{prefix}.{node.name}", node) for node in module.body
                                       if isinstance(node, ast.ClassDef)]
        for name, scope in scopes:
            for node in scope.body:
                if isinstance(node, ast.FunctionDef) and not re.match(r"_(?!_)", node.name):
                    functions.setdefault(f"{name}.{node.name}", []).append(node)
    return {name: signature_of(nodes) for name, nodes in functions.items()}


SIGNATURES = read_signatures()


def choose_signature(_app, what, name, _object, _options, signature, result):
    if what == "class":
        # Those without a constructor are made by other calls.
        return SIGNATURES.get(name + ".__init__", ("", ""))[0], None
    return SIGNATURES.get(name, (signature, result))


def setup(app):
    app.connect("autodoc-process-signature", choose_signature)
