#!/usr/bin/env python3
"""How long the sentences and paragraphs of the documents are.

    plain_words_test.py                 compares each document with its limits
    plain_words_test.py FILE...         prints what the files have, the longest paragraph last

A paragraph is a block of text or an item of a list; headings, tables, code and formulas do not
count. A sentence ends with a full stop, question or exclamation mark before a capital, or with its
paragraph. A word is what stands between spaces and has a letter or digit.
"""
import os
import re
import statistics
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
# Words of the median sentence, and of the longest paragraph. Limits only ever fall.
GOOD = (17, 120)
LIMITS = {
    "README.md": GOOD,
    "CHANGELOG.md": GOOD,
    "CONTRIBUTING.md": GOOD,
    "formats/SPEC.md": GOOD,
    "offline/README.md": GOOD,
    "offline/MEASURED.md": GOOD,
    "offline/adjustment/DESIGN.md": GOOD,
    "offline/calibration/DESIGN.md": GOOD,
    "offline/camera/DESIGN.md": GOOD,
    "offline/dataset/DESIGN.md": GOOD,
    "offline/evaluation/DESIGN.md": GOOD,
    "offline/exchange/DESIGN.md": GOOD,
    "offline/experiments/README.md": GOOD,
    "offline/features/README.md": GOOD,
    "offline/features/DESIGN.md": GOOD,
    "offline/initialization/DESIGN.md": GOOD,
    "offline/packing/DESIGN.md": GOOD,
    "offline/python/README.md": GOOD,
    "offline/python/DESIGN.md": GOOD,
    "offline/report/DESIGN.md": GOOD,
    "runtime/README.md": GOOD,
    "runtime/DESIGN.md": GOOD,
    "runtime/COST.md": GOOD,
    "runtime/libcamera/README.md": GOOD,
    "runtime/python/README.md": GOOD,
    "runtime/v4l2/README.md": GOOD,
    "tests/DESIGN.md": GOOD,
}
SENTENCE_END = re.compile(r"(?<=[.?!])[)\"*]*\s+(?=[A-Z0-9`\"*(\[|−+]|$)|(?<=:)\s*$")
ABBREVIATIONS = re.compile(r"\b(e\.g|i\.e|et al|cf)\.")


def read_paragraphs(text):
    """Texts of the paragraphs."""
    text = re.sub(r"^ *```.*?^ *```$", "", text, flags=re.MULTILINE | re.DOTALL)
    paragraphs, current = [], []
    for line in text.split("\n") + [""]:
        is_prose = line.strip() and not re.match(r"#|\||    \s*\S.*=|<|\s*-{3,}$", line)
        starts = re.match(r"\s*([-*]|\d+\.)\s+", line)
        if current and (not is_prose or starts):
            paragraphs.append(" ".join(current))
            current = []
        if is_prose:
            current.append(line[starts.end():] if starts else line.strip())
    return paragraphs


def count_words(text):
    return sum(any(c.isalnum() for c in word) for word in text.split())


def read_sentences(paragraph):
    plain = ABBREVIATIONS.sub(lambda match: match.group().replace(".", ""), paragraph)
    return [part for part in SENTENCE_END.split(plain) if part and count_words(part)]


def measure(path):
    """Median sentence, longest paragraph, in words, and that paragraph."""
    with open(path, encoding="utf-8") as file:
        paragraphs = read_paragraphs(file.read())
    sentences = [count_words(s) for paragraph in paragraphs for s in read_sentences(paragraph)]
    longest = max(paragraphs, key=count_words)
    return statistics.median(sentences), count_words(longest), longest


def main():
    for path in sys.argv[1:]:
        median, longest, text = measure(path)
        print(f"{path}: median sentence {median:g} words, longest paragraph {longest}\n  {text[:200]}")
    if sys.argv[1:]:
        return
    faults = []
    for name, (most_median, most_longest) in LIMITS.items():
        median, longest, text = measure(os.path.join(ROOT, name))
        print(f"{name}: median sentence {median:g} words, longest paragraph {longest}")
        if median > most_median:
            faults.append(f"{name}: half of the sentences have {median:g} words or more, "
                          f"not {most_median}; divide the long ones")
        if longest > most_longest:
            faults.append(f"{name}: a paragraph of {longest} words, not {most_longest}: {text[:60]}...")
    if faults:
        sys.exit("\n".join(faults))


if __name__ == "__main__":
    main()
