#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Fails if a folder of panoptic/ or a header of include/panoptic/ includes what panoptic/LAYERS does not allow it, or the
operating system's headers anywhere but in its seam; or if the umbrella header brings a user too much.

Usage: check_layers.py [ROOT]"""
import pathlib
import re
import sys

SYSTEM = re.compile(r"\s*#\s*include\s*<(unistd\.h|fcntl\.h|sys/[^>]*)>")
SYSTEM_SEAM = ("base/os.cpp", "base/child_process.cpp")  # the files that call the operating system
UMBRELLA = "panoptic.h"  # includes public headers of every folder, and nobody in panoptic/ includes it
MOST_LINES = 1500  # of ours that the umbrella brings


class Layers:
    def __init__(self, text):
        self.allowed = {}  # folder -> folders below it
        self.public = {}  # public header -> its folder
        for line in text.splitlines():
            name, colon, names = line.partition(":")
            if not colon or line.startswith("#"):
                continue
            if name.startswith("include "):
                self.public.update(dict.fromkeys(names.split(), name.split()[1]))
            else:
                self.allowed[name.strip()] = set(names.split())

    def may_see(self, folder, other):
        return other == folder or other in self.allowed[folder]

    def folder_of(self, included):
        """The folder of panoptic/<folder>/<file> or panoptic/<public header>; nothing for anything else."""
        parts = included.split("/")
        if parts[0] != "panoptic" or len(parts) not in (2, 3):
            return None
        return self.public.get(parts[1]) if len(parts) == 2 else parts[1]


def includes(path):
    """Number and name of what is included of ours, or in quotes."""
    for number, line in enumerate(path.read_text().splitlines(), 1):
        include = re.match(r'\s*#\s*include\s*["<]([^">]+)[">]', line)
        if include and ('"' in line or include[1].startswith("panoptic/")):
            yield number, include[1]


def internal_errors(root, layers):
    for path in sorted((root / "panoptic").glob("*/*")):
        folder = path.parent.name
        if path.suffix not in (".h", ".cpp"):
            continue
        if folder not in layers.allowed:
            yield f"{path}: the folder '{folder}' is not in panoptic/LAYERS"
            continue
        for number, included in includes(path):
            other = layers.folder_of(included)
            if other is None:
                yield f'{path}:{number}: write "panoptic/<folder>/<file>" or "panoptic/<public header>", not "{included}"'
            elif not layers.may_see(folder, other):
                yield f"{path}:{number}: '{folder}' may not include '{other}' (panoptic/LAYERS)"


def system_errors(root):
    for path in sorted((root / "panoptic").glob("*/*")):
        if path.suffix not in (".h", ".cpp") or path in [root / "panoptic" / seam for seam in SYSTEM_SEAM]:
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if included := SYSTEM.match(line):
                yield f"{path}:{number}: <{included[1]}> stays behind panoptic/{SYSTEM_SEAM[0]} and {SYSTEM_SEAM[1]}"


def public_errors(root, layers):
    headers = {path.name: path for path in sorted((root / "include/panoptic").glob("*.h")) if path.name != UMBRELLA}
    for name in layers.public.keys() - headers.keys():
        yield f"panoptic/LAYERS: there is no include/panoptic/{name}"
    for name, path in headers.items():
        folder = layers.public.get(name)
        if folder not in layers.allowed:
            yield f"{path}: the header is not in panoptic/LAYERS"
            continue
        for number, included in includes(path):
            if included.count("/") != 1 or layers.folder_of(included) is None:
                yield f"{path}:{number}: a public header may not include '{included}'"
            elif not layers.may_see(folder, layers.folder_of(included)):
                yield f"{path}:{number}: '{folder}' may not include '{layers.folder_of(included)}' (panoptic/LAYERS)"


def umbrella_errors(root):
    folder = root / "include/panoptic"
    seen, todo = set(), [UMBRELLA]
    while todo:
        name = todo.pop()
        if name in seen or not (folder / name).is_file():
            continue
        seen.add(name)
        todo += [included.removeprefix("panoptic/") for _, included in includes(folder / name)]
    lines = sum(len((folder / name).read_text().splitlines()) for name in seen)
    if lines >= MOST_LINES:
        yield f"{folder / UMBRELLA}: brings {lines} lines of {len(seen)} headers; fewer than {MOST_LINES} are allowed"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent)
    layers = Layers((root / "panoptic/LAYERS").read_text())
    errors = [*internal_errors(root, layers), *public_errors(root, layers), *system_errors(root), *umbrella_errors(root)]
    print("\n".join(errors) or f"layers: {len(layers.allowed)} folders, {len(layers.public)} public headers, no findings",
          file=sys.stderr if errors else sys.stdout)
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
