#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Prints a header with its comments as doxygen wants them: docs/Doxyfile calls it for each file.

Our comments are plain (`// text` before what they are about, or behind it on its line); doxygen takes `///` and `///<`. The comment at
the top of a file becomes that of the file. Lines that are indented within a comment are shown as they stand.

Usage: doxygen_filter.py FILE
"""
import re
import sys

COMMENT = re.compile(r"^(?P<indent>\s*)//(?P<text>.*)$")
BEHIND = re.compile(r"^(?P<code>.*[;,{}(\w]\s*)// (?P<text>[^\"]*)$")


def escaped(text):
    """Text in which no character means anything to doxygen."""
    return re.sub(r"([\\@<>#$&%])", r"\\\1", text).replace("::", "\\::")


def block(texts, indent):
    """The lines of one comment."""
    shown = False
    for text in texts:
        is_code = text.startswith("  ")
        if is_code != shown:
            yield f"{indent}/// \\{'verbatim' if is_code else 'endverbatim'}"
            shown = is_code
        yield f"{indent}/// {text if is_code else escaped(text)}".rstrip()
    if shown:
        yield f"{indent}/// \\endverbatim"


def filtered(lines):
    i = 0
    at_top = True
    while i < len(lines):
        comment = COMMENT.match(lines[i])
        if not comment:
            at_top = at_top and not lines[i].strip()
            behind = BEHIND.match(lines[i])
            yield f"{behind['code']}///< {escaped(behind['text'])}" if behind and not at_top else lines[i]
            i += 1
            continue
        texts = []
        while i < len(lines) and COMMENT.match(lines[i]):
            texts.append(COMMENT.match(lines[i])["text"].removeprefix(" "))
            i += 1
        texts = [text for text in texts if not text.startswith(("SPDX-", "clang-format", "NOLINT"))]
        if at_top:
            yield "/// \\file"
        yield from block(texts, comment["indent"])
        if at_top:
            yield ""
            at_top = False


def main():
    if len(sys.argv) != 2:
        print(__doc__.strip(), file=sys.stderr)
        return 2
    with open(sys.argv[1], encoding="utf-8") as file:
        print("\n".join(filtered(file.read().splitlines())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
