"""Checks JSON of the programs against formats/json."""
import functools
import json
import os

import jsonschema

FOLDER = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "formats", "json"))
FILES = {"result.json": "result", "session.json": "session", "unit.json": "unit", "difference.json": "commands"}


@functools.lru_cache(None)
def load(name):
    with open(os.path.join(FOLDER, name + ".schema.json"), encoding="utf-8") as file:
        return json.load(file)


@functools.lru_cache(None)
def validator(name, definition=""):
    schema = load(name)
    if definition:
        schema = {"$schema": schema["$schema"], "$ref": "#/$defs/" + definition, "$defs": schema["$defs"]}
    return jsonschema.Draft202012Validator(schema)


def check(instance, name, definition=""):
    """Fails if the instance is not as the schema says, and names the place."""
    error = jsonschema.exceptions.best_match(validator(name, definition).iter_errors(instance))
    if error:
        place = "/".join(map(str, error.absolute_path))
        raise AssertionError(f"{definition or name} schema: at '{place}': {error.message[:500]}")


def check_output(arguments, text):
    """Checks what a command of raygrid printed with --json."""
    command = arguments[0]
    if command == "capture":
        for line in text.splitlines():
            check(json.loads(line), "capture")
    elif command == "calibrate":
        check(json.loads(text), "result")
    else:
        lists = command == "export" and "--list" in arguments
        check(json.loads(text), "commands", "export_list" if lists else command)


def check_file(path):
    """Checks a file that has a schema."""
    name = os.path.basename(path)
    with open(path, encoding="utf-8", errors="replace") as file:
        instance = json.load(file)
    if name.endswith(".failed.json"):
        check(instance, "unit")
    else:
        check(instance, FILES[name], "compare" if name == "difference.json" else "")


def has_schema(name):
    return name in FILES or name.endswith(".failed.json")
