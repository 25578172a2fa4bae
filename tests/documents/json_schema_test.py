#!/usr/bin/env python3
"""The schemas of JSON files and outputs are complete, and their page is theirs."""
import importlib.machinery
import importlib.util
import json
import os
import sys
import unittest

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "tests/support"))
import jsonschema
import json_schemas

NAMES = ("result", "session", "unit", "capture", "commands")


def json_page():
    loader = importlib.machinery.SourceFileLoader("json_page", os.path.join(ROOT, "tools/json_page"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("json_page", loader))
    loader.exec_module(module)
    return module


def properties(node, place=""):
    """All keys in a schema, and what it says of them."""
    if isinstance(node, list):
        for k, element in enumerate(node):
            yield from properties(element, f"{place}[{k}]")
    if not isinstance(node, dict):
        return
    for key, value in node.get("properties", {}).items():
        if key != "required" or isinstance(value, dict):
            yield f"{place}/{key}", value
    for key, value in node.items():
        if key in ("if", "const", "enum", "required"):
            continue
        yield from properties(value, f"{place}/{key}")


def objects(node):
    if isinstance(node, (dict, list)):
        for value in node.values() if isinstance(node, dict) else node:
            yield from objects(value)
    if isinstance(node, dict) and node.get("type") == "object" and "properties" in node:
        yield node


class JsonSchemaTest(unittest.TestCase):
    def test_schemas_are_valid(self):
        for name in NAMES:
            jsonschema.Draft202012Validator.check_schema(json_schemas.load(name))

    def test_every_key_has_a_title_a_description_and_a_unit(self):
        resolved = json_page().resolved
        for name in NAMES:
            schema = json_schemas.load(name)
            for place, value in properties(schema):
                value = resolved(value, schema)
                self.assertTrue(value.get("title") and value.get("description"), name + place)
                if value.get("type") in ("number", "integer", ["number", "null"]):
                    self.assertTrue(value.get("unit") or value["title"] == "Metric", name + place)

    def test_keys_without_a_schema_are_errors(self):
        for name in NAMES:
            schema = json_schemas.load(name)
            parts = [schema["$defs"][key] for key in ("camera_keys", "metrics") if key in schema["$defs"]]
            for node in objects(schema):
                closed = {"additionalProperties", "unevaluatedProperties"} & node.keys()
                self.assertTrue(closed or node in parts, node.get("title"))
        frame = {"image": "a.png", "time_s": 1.0}
        session = {"schema_version": 2, "image_size": [4, 3], "frames": [frame]}
        json_schemas.check(session, "session")
        for key in ("deviation_px", "seconds"):
            frame[key] = 1.0
            with self.assertRaisesRegex(AssertionError, key):
                json_schemas.check(session, "session")
            del frame[key]

    def test_generated_files_are_those_of_the_schemas(self):
        for path, text in json_page().GENERATED.items():
            with open(os.path.join(ROOT, path), encoding="utf-8") as file:
                self.assertEqual(file.read(), text(), path + " is stale: run tools/json_page")


if __name__ == "__main__":
    unittest.main()
