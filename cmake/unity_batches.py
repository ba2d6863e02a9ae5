# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Puts sources together so that what they include is compiled once for several of them.

    unity_batches.py ROOT OUTPUT_FOLDER SOURCE...

Writes OUTPUT_FOLDER/unity_<first source>.cpp files that include their sources by paths below ROOT, so that a compiler cache
knows them again in another clone, and prints what to compile, one path a line. Three rules:
- No source of a batch says a name that is local to another: none can call the other's helper.
- A source with preprocessor definitions of its own stays alone.
- Where batches end depends on the names of files alone: a new file changes the batches near it, not all after it."""
import hashlib
import pathlib
import re
import sys

kMostLines = 2500
kOneEndsIn = 24  # files, on average

kLocalBlock = re.compile(r"^namespace \{\n(.*?)^\}  // namespace$", re.M | re.S)
kLocalName = re.compile(
    r"^(?:\[\[\w+\]\] )?(?:(?:struct|class|enum class|enum|union) (?P<type>\w+)|using (?P<alias>\w+) ="
    r"|(?![#/}\s]|using |namespace )(?:[^=(\n]|\(\*)*?[\s*&](?P<name>\w+)\s*(?:\(|=|\{|;|\[))", re.M)
kInternal = re.compile(r"^(?:static .*?(\w+)\s*[(={;\[]|(?:constexpr|const) [^(\n]*?(\w+)\s*[={;\[])", re.M)
kSaidName = re.compile(r"(?<![\w.:>])(?:(\w+)\(|(k[A-Z]\w*))")  # calls and constants; not members, nor what names its namespace
kAlone = re.compile(r"^#\s*(?:define|undef|pragma)|^using namespace|^asm\(", re.M)


def local_names(text):
    names = {a or b for a, b in kInternal.findall(text)}
    for block in kLocalBlock.findall(text):
        names.update(m["type"] or m["alias"] or m["name"] for m in kLocalName.finditer(block))
    return names


def said_names(text):
    return {call or constant for call, constant in kSaidName.findall(re.sub(r"//.*", "", text))}


def ends_batches(name):
    return hashlib.sha256(name.encode()).digest()[0] % kOneEndsIn == 0


class Batch:
    def __init__(self):
        self.sources, self.local, self.said, self.lines = [], set(), set(), 0

    def takes(self, other):
        fits = self.lines + other.lines <= kMostLines
        return fits and not self.local & other.said and not other.local & self.said

    def add(self, other):
        self.sources += other.sources
        self.local |= other.local
        self.said |= other.said
        self.lines += other.lines


def batch_of(source, text):
    batch = Batch()
    batch.sources, batch.local, batch.lines = [source], local_names(text), text.count("\n")
    batch.said = said_names(text) | batch.local
    return batch


def batches(sources):
    """Lists of sources that go together. Each goes to the first that takes it, among those since the last end of all."""
    ended, growing = [], []
    for source in sorted(sources):
        text = source.read_text(encoding="utf-8")
        batch = batch_of(source, text)
        if kAlone.search(text):
            ended.append(batch)
            continue
        home = next((b for b in growing if b.takes(batch)), None)
        home.add(batch) if home else growing.append(batch)
        if ends_batches(source.name):
            ended += growing
            growing = []
    return [b.sources for b in ended + growing]


def write_if_changed(path, text):
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def main(root, output, *sources):
    root, output = pathlib.Path(root), pathlib.Path(output)
    for batch in batches([pathlib.Path(s) for s in sources]):
        if len(batch) == 1:
            print(batch[0])
            continue
        unity = output / f"unity_{batch[0].name}"
        write_if_changed(unity, "".join(f'#include "{s.relative_to(root)}"\n' for s in batch))
        print(unity)


if __name__ == "__main__":
    main(*sys.argv[1:])
