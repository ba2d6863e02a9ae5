#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Checks what neither clang-format nor clang-tidy looks at: licence lines, file lengths, paths of somebody's machine, names, how
comments begin, and what batches of sources hide from clang-tidy.

Usage: check_style.py [FILE...]    default: every file that git tracks or would add
"""
import pathlib
import re
import subprocess
import sys

GUIDE_LINES = 300
MOST_LINES = 400
SPDX = ("SPDX-FileCopyrightText: 2026 The PanopticFusion Authors", "SPDX-License-Identifier: Apache-2.0")
SOURCES = {".h", ".cpp", ".py", ".cmake", ".toml", ".sh", ".mjs", ".js"}
UNCHECKED = {"LICENSE", "package-lock.json"}
FORBIDDEN = [
    (re.compile(r"(?<![\w.])/(work|home|root|Users|mnt)/\w"), "a path of one machine"),
    (re.compile(r"\b(registry\.npmjs|pypi\.org|files\.pythonhosted|deb\.debian|crates\.io)"), "a package registry"),
    (re.compile(r'^#include ".*\.cpp"'), "a source that includes a source"),
    (re.compile(r"^(class|struct) \w*(Manager|Handler|Helper|Util|Utils|Impl)\b"), "a name that says nothing"),
    (re.compile(r"^ .*\bget_\w+\(.*\) const(?! override)"), "a getter: name the thing itself"),
    (re.compile(r"[ \t]+$"), "white space at the end of the line"),
    (re.compile(r"\t"), "a tab"),
]
COMMENTED = {".h", ".cpp", ".mjs", ".js"}
NO_SUBJECT = re.compile(r"\s*// (Of|As|What)\b")
IN_COMMENT = re.compile(r"\s*// (?!SPDX)")


def is_source(path, text):
    return path.suffix in SOURCES or path.name == "CMakeLists.txt" or text.startswith("#!")


def findings(path):
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return  # a picture or other binary file
    lines = text.splitlines()
    if text and not text.endswith("\n"):
        yield len(lines), "the last line has no end"
    if is_source(path, text):
        if not all(any(line in head for head in lines[:4]) for line in SPDX):
            yield 1, "the two SPDX lines are missing at the top"
        if path.suffix == ".h" and "#pragma once" not in lines:
            yield 1, "#pragma once is missing"
        if len(lines) > MOST_LINES and path.suffix != ".toml":
            yield len(lines), f"more than {MOST_LINES} lines (the guide is {GUIDE_LINES}): divide it"
    for number, line in enumerate(lines, 1):
        for pattern, what in FORBIDDEN:
            if pattern.search(line) and not (path.suffix == ".md" and what.startswith("white")):
                yield number, what


def comments_without_subject(path):
    """Comments that begin with Of, As or What: a comment is a sentence with a subject, or a noun phrase."""
    if path.suffix not in COMMENTED:
        return
    before = ""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        begins = NO_SUBJECT.match(line)
        if begins and not IN_COMMENT.match(before):
            yield number, f"a comment that begins with '{begins[1]}': give it a subject"
        before = line


def unused_names(path):
    """Names from elsewhere that nothing in the source says: clang-tidy looks for them in the file that it was given, a batch."""
    if path.suffix != ".cpp":
        return
    text = re.sub(r"//.*", "", path.read_text(encoding="utf-8"))
    for brought in re.finditer(r"^ *(?:using (?:\w*::)+(\w+);|namespace (\w+) = )", text, re.M):
        name = brought[1] or brought[2]
        if len(re.findall(rf"\b{name}\b", text)) == 1 + brought[0].count(f"{name}::"):
            yield text.count("\n", 0, brought.start()) + 1, f"the name '{name}' is brought here and not used"


def doubled_types(paths):
    """Two types of one name in two headers: the linker takes either's functions for both."""
    places = {}
    for path in paths:
        if path.suffix != ".h" or not path.is_file():
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            definition = re.match(r"(?:struct|class|enum class) (\w+)(?!\w|::)[^;]*[{:]", line)
            if definition:
                places.setdefault(definition[1], []).append((path, number))
    for name, found in places.items():
        for path, number in found[1:]:
            yield path, number, f"the type {name} is defined in {found[0][0].name} too"


def files():
    if len(sys.argv) > 1:
        return [pathlib.Path(name) for name in sys.argv[1:]]
    listing = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], check=True, capture_output=True, text=True,
                             cwd=pathlib.Path(__file__).parent.parent).stdout
    return [pathlib.Path(__file__).parent.parent / name for name in listing.splitlines()]


def main():
    checked = 0
    wrong = 0
    paths = files()
    for path, number, what in doubled_types(paths):
        wrong += 1
        print(f"{path}:{number}: {what}", file=sys.stderr)
    for path in paths:
        if path.name in UNCHECKED or path == pathlib.Path(__file__) or not path.is_file():
            continue
        checked += 1
        for number, what in [*findings(path), *comments_without_subject(path), *unused_names(path)]:
            wrong += 1
            print(f"{path}:{number}: {what}", file=sys.stderr)
    if wrong == 0:
        print(f"style: {checked} files, no findings")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
