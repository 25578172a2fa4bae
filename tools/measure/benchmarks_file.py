"""BENCHMARKS.md: one section a part, of which those that were measured are written anew."""
import re

import both_ways
import frame_paths
import remap
import sets
import tables

PREFACE = """# Benchmarks

Everything here is printed by `tools/measure_readme`, which builds what it measures, and is kept as it was printed. `--only accuracy`,
`--only both-ways`, `--only remap` and `--only paths` measure a part each.

"""
ORDER = ("Figures of README.md", "Corners, model and board", "Held-out errors", "Rigid and flexed", "Undistortion beside cv::remap",
         "Ways of frames")


def read_sections(path):
    try:
        with open(path, encoding="utf-8") as file:
            parts = re.split(r"^## (.*)\n", file.read(), flags=re.MULTILINE)
    except FileNotFoundError:
        return {}
    return dict(zip(parts[1::2], parts[2::2]))


def write(path, sections):
    """Sections by title, other than those that stand in the file already."""
    sections = {**read_sections(path), **sections}
    text = PREFACE
    for title in ORDER:
        if title in sections:
            text += f"## {title}\n{sections[title].strip()}\n\n"
    with open(path, "w", encoding="utf-8") as file:
        file.write(text.rstrip() + "\n")


def accuracy_sections(results, blob_bytes, absent):
    held_out = [tables.RULE, ""]
    held_out += [f"Skipped, as it was not there: {name}." for name in absent]
    for result in results:
        if result["job"].get("kind") not in sets.CORNERS_WITHOUT_TABLE:
            held_out += tables.set_text(result)
    titles = ORDER[:3]
    lines = tables.readme_figures(results, blob_bytes), tables.decomposition_text(results), held_out
    return {title: "\n".join(text) + "\n" for title, text in zip(titles, lines)}


def both_ways_sections(measured, absent):
    return {ORDER[3]: "\n".join(both_ways.text(measured, absent)) + "\n"}


def remap_sections(measured):
    return {ORDER[4]: "\n".join(remap.text(measured)) + "\n"}


def paths_sections(measured):
    return {ORDER[5]: "\n".join(frame_paths.text(measured)) + "\n"}
