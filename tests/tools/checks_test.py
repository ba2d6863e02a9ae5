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
        self.write("panoptic/LAYERS", "# comment\nbase:\nmap: base\nio: base map\n\ninclude base: error.h\ninclude map: voxels.h\n")
        self.write("include/panoptic/error.h", "")
        self.write("include/panoptic/voxels.h", '#include "panoptic/error.h"\n')
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

    def test_layers_keep_the_operating_system_behind_its_seam(self):
        self.assertEqual(self.layers_after("panoptic/base/os.cpp", "#include <unistd.h>\n")[0], 0)
        code, text = self.layers_after("panoptic/io/a.cpp", "#include <sys/stat.h>\n")
        self.assertEqual(code, 1)
        self.assertIn("<sys/stat.h> stays behind panoptic/base/os.cpp", text)

    def test_layers_know_which_folder_a_public_header_is_of(self):
        self.assertEqual(self.layers_after("panoptic/map/a.h", '#include "panoptic/voxels.h"\n#include "panoptic/error.h"\n')[0], 0)
        code, text = self.layers_after("panoptic/base/a.h", '#include "panoptic/voxels.h"\n')
        self.assertEqual(code, 1)
        self.assertIn("a.h:1: 'base' may not include 'map'", text)
        self.assertEqual(self.layers_after("panoptic/base/a.h", '#include "panoptic/unknown.h"\n')[0], 1)

    def test_layers_keep_public_headers_apart_from_internal_ones_and_in_order(self):
        code, text = self.layers_after("include/panoptic/voxels.h", '#include "panoptic/map/a.h"\n')
        self.assertEqual(code, 1)
        self.assertIn("voxels.h:1: a public header may not include 'panoptic/map/a.h'", text)
        code, text = self.layers_after("include/panoptic/error.h", "#include <panoptic/voxels.h>\n")
        self.assertEqual(code, 1)
        self.assertIn("error.h:1: 'base' may not include 'map'", text)

    def test_layers_list_every_public_header_that_there_is_and_no_other(self):
        self.assertIn("new.h: the header is not in panoptic/LAYERS", self.layers_after("include/panoptic/new.h", "")[1])
        self.write("panoptic/LAYERS", "base:\ninclude base: gone.h\n")
        self.assertIn("there is no include/panoptic/gone.h", run("check_layers.py", str(self.root))[1])

    def test_layers_refuse_a_folder_without_a_floor(self):
        self.assertIn("not in panoptic/LAYERS", self.layers_after("panoptic/extra/a.cpp", "")[1])

    def test_layers_count_the_lines_that_the_umbrella_header_brings(self):
        self.write("include/panoptic/error.h", "int a;\n" * 800)
        self.assertEqual(self.layers_after("include/panoptic/panoptic.h", '#include "panoptic/voxels.h"\n')[0], 0)
        self.write("include/panoptic/panoptic.h", '#include "panoptic/error.h"\n' + "int b;\n" * 699)
        self.write("include/panoptic/error.h", "int a;\n" * 800)
        code, text = run("check_layers.py", str(self.root))
        self.assertEqual(code, 1)
        self.assertIn("panoptic.h: brings 1500 lines of 2 headers", text)

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

    def test_style_finds_a_comment_without_a_subject(self):
        for comment in ("// What it does.", "// Of all of them:", "  // As the other."):
            code, message = run("check_style.py", self.write("a.h", LICENCE + "//\n#pragma once\n\n" + comment + "\nint a();\n"))
            self.assertEqual(code, 1, comment)
            self.assertIn("give it a subject", message)
        for comment in ("// It does\n// What you see is what you get.", "// Offsets.", "int b;  // as in a", "// Whatever it is."):
            self.assertEqual(run("check_style.py", self.write("a.h", LICENCE + "#pragma once\n" + comment + "\n"))[0], 0, comment)

    def test_style_finds_what_batches_of_sources_hide_from_clang_tidy(self):
        code, message = run("check_style.py", self.write("a.cpp", LICENCE + '#include "panoptic/b.cpp"\n'))
        self.assertEqual(code, 1)
        self.assertIn("a source that includes a source", message)
        for unused in ("using a::b;", "  using ::testing::b;", "namespace b = a::c;"):
            code, message = run("check_style.py", self.write("a.cpp", LICENCE + unused + "\nint c = bb();\n"))
            self.assertEqual(code, 1, unused)
            self.assertIn("the name 'b' is brought here and not used", message)
        for used in ("using a::b;\nb c;\n", "using b::b;\nint c = b(2);\n", "namespace b = a::c;\nb::d e;\n"):
            self.assertEqual(run("check_style.py", self.write("a.cpp", LICENCE + used))[0], 0, used)

    def test_style_finds_a_type_that_two_headers_define(self):
        one = self.write("one.h", LICENCE + "#pragma once\nstruct Surface {\n};\n")
        two = self.write("two.h", LICENCE + "#pragma once\nenum class Surface : int { kA };\n")
        other = self.write("other.h", LICENCE + "#pragma once\nstruct Surface;\n")
        self.assertEqual(run("check_style.py", one, other)[0], 0)
        code, message = run("check_style.py", one, two)
        self.assertEqual(code, 1)
        self.assertIn("the type Surface is defined in one.h too", message)

    def test_doxygen_gets_comments_in_its_form(self):
        header = LICENCE + "//\n// Chairs <&> more.\n//   int x;\n#pragma once\n\n// A chair.\nstruct Chair {\n  int legs = 4;  // mostly\n};\n"
        result = subprocess.run([sys.executable, TOOLS / "doxygen_filter.py", self.write("a.h", header)], capture_output=True, text=True)
        self.assertEqual(result.stdout.splitlines(),
                         ["/// \\file", "///", "/// Chairs \\<\\&\\> more.", "/// \\verbatim", "///   int x;", "/// \\endverbatim", "",
                          "#pragma once", "", "/// A chair.", "struct Chair {", "  int legs = 4;  ///< mostly", "};"])


if __name__ == "__main__":
    unittest.main()
