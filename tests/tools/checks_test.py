# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""The checks of tools/ find what they are there to find."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

TOOLS = pathlib.Path(__file__).resolve().parents[2] / "tools"
LICENCE = "// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors\n// SPDX-License-Identifier: Apache-2.0\n"


def run(tool, *arguments):
    result = subprocess.run([sys.executable, TOOLS / tool, *arguments], capture_output=True, text=True)
    return result.returncode, result.stderr


class Checks(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        self.addCleanup(self.folder.cleanup)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return str(path)

    def layers_after(self, name, text):
        self.write("panoptic/LAYERS", "# comment\nbase:\nmap: base\nio: base map\n")
        self.write(name, text)
        return run("check_layers.py", str(self.root))

    def test_layers_accept_what_is_allowed(self):
        self.assertEqual(self.layers_after("panoptic/io/a.cpp", '#include <map>\n#include "panoptic/map/b.h"\n#include "panoptic/io/a.h"\n')[0], 0)

    def test_layers_refuse_a_floor_above(self):
        code, text = self.layers_after("panoptic/base/a.h", '\n#include "panoptic/map/b.h"\n')
        self.assertEqual(code, 1)
        self.assertIn("a.h:2: 'base' may not include 'map'", text)

    def test_layers_refuse_angle_brackets_and_relative_paths_as_a_way_round(self):
        self.assertEqual(self.layers_after("panoptic/base/a.h", "#  include <panoptic/map/b.h>\n")[0], 1)
        self.assertEqual(self.layers_after("panoptic/base/a.h", '#include "../map/b.h"\n')[0], 1)

    def test_layers_refuse_a_folder_without_a_floor(self):
        self.assertIn("not in panoptic/LAYERS", self.layers_after("panoptic/extra/a.cpp", "")[1])

    def test_style_accepts_a_proper_file(self):
        self.assertEqual(run("check_style.py", self.write("a.h", LICENCE + "#pragma once\n"))[0], 0)

    def test_style_finds_each_fault(self):
        faults = {
            "SPDX": "int a;\n",
            "pragma once": LICENCE,
            "one machine": LICENCE + '#pragma once\nauto p = "/ho' + 'me/me/x";\n',
            "white space": LICENCE + "#pragma once\nint a; \n",
            "a tab": LICENCE + "#pragma once\n\tint a;\n",
            "no end": LICENCE + "#pragma once\nint a;",
            "says nothing": LICENCE + "#pragma once\nclass MapManager;\n",
            "a getter": LICENCE + "#pragma once\n  int ge" + "t_size() const;\n",
            "more than 400": LICENCE + "#pragma once\n" + "int a;\n" * 400,
        }
        for what, text in faults.items():
            code, message = run("check_style.py", self.write("a.h", text))
            self.assertEqual(code, 1, what)
            self.assertIn(what, message)

    def test_style_finds_a_type_that_two_headers_define(self):
        one = self.write("one.h", LICENCE + "#pragma once\nstruct Surface {\n};\n")
        two = self.write("two.h", LICENCE + "#pragma once\nenum class Surface : int { kA };\n")
        other = self.write("other.h", LICENCE + "#pragma once\nstruct Surface;\n")
        self.assertEqual(run("check_style.py", one, other)[0], 0)
        code, message = run("check_style.py", one, two)
        self.assertEqual(code, 1)
        self.assertIn("the type Surface is defined in one.h too", message)


if __name__ == "__main__":
    unittest.main()
