# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""The arithmetic and the tables of tools/bench_compare.py, bench_tables.py and svg_chart.py, by hand-made numbers."""
import pathlib
import sys
import unittest
import xml.etree.ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
import bench_compare  # noqa: E402
import bench_tables  # noqa: E402
import svg_chart  # noqa: E402


def runs(**medians):
    """One run for each of the medians of a stage."""
    count = len(next(iter(medians.values())))
    return [{"stages": {stage: {"p50_ms": values[i]} for stage, values in medians.items()}} for i in range(count)]


class Comparing(unittest.TestCase):
    def test_a_stage_counts_with_its_smallest_median(self):
        rows = bench_compare.compared(runs(fusion_cpu=[4.0, 5.0, 4.5]), runs(fusion_cpu=[9.0, 4.4, 4.6]))
        base, head, change, spread = rows["fusion_cpu"]
        self.assertEqual((base, head), (4.0, 4.4))
        self.assertAlmostEqual(change, 10.0)
        self.assertAlmostEqual(spread, 100 * (0.5 ** 2 / 1.5) ** 0.5 / 4.0)  # standard deviation of 4, 5, 4.5 over 4

    def test_fails_over_the_limit_and_not_at_it(self):
        def grown(percent):
            return bench_compare.compared(runs(fusion_cpu=[100.0]), runs(fusion_cpu=[100.0 + percent]))

        self.assertIsNone(bench_compare.verdict(grown(25.0), 25))
        self.assertIsNone(bench_compare.verdict(grown(-20.0), 5))
        self.assertIn("6.0 %", bench_compare.verdict(grown(6.0), 5))

    def test_leaves_out_what_one_side_lacks_and_what_takes_no_time(self):
        rows = bench_compare.compared(runs(fusion_cpu=[1.0], old=[1.0], maintain=[0.0]), runs(fusion_cpu=[1.0], new=[1.0], maintain=[0.1]))
        self.assertEqual(list(rows), ["fusion_cpu"])

    def test_says_whether_the_maps_are_the_same(self):
        rows = bench_compare.compared(runs(fusion_cpu=[2.0]), runs(fusion_cpu=[1.0]))
        self.assertIn("-50.0%", bench_compare.report(rows, True))
        self.assertTrue(bench_compare.report(rows, False).endswith("the maps differ"))


class Tables(unittest.TestCase):
    def test_a_stage_is_the_sum_of_its_parts_beside_its_target(self):
        def result(threads, ms):
            names = ("register", "reference", "track", "integrate", "fusion", "mesh_incremental", "mesh_full")
            return {"threads": threads, "voxel_size_m": 0.0240000002, "stages": {n: {"p50_ms": ms, "p95_ms": 2 * ms} for n in names}}

        table = bench_tables.stages_table(result(1, 0.5), result(2, 0.25))
        self.assertIn("| reference + track | 1.00 | 2.00 | 0.50 | 1.00 | 1 |", table)
        self.assertIn("2 threads p50", table)

    def test_bytes_and_operations_over_the_limits_are_milliseconds(self):
        row = bench_tables.roofline_row("x", 30e6, 100e6, 4.0, {"copy_gb_per_s": 15.0, "float_gop_per_s": 200.0})
        self.assertEqual(row, ["x", "30.0", "100", "2.00", "0.50", "4.00", "50 %"])

    def test_growth_compares_the_largest_map_with_the_smallest(self):
        line = bench_tables.growth_line([{"blocks": 100, "fusion": 4.0}, {"blocks": 500, "fusion": 9.0}, {"blocks": 1600, "fusion": 4.2}])
        self.assertIn("16.0 times", line)
        self.assertIn("+5 %", line)

    def test_a_section_is_replaced_and_the_rest_is_kept(self):
        text = "a\n<!-- make_benchmarks: x -->\nold\n<!-- end -->\nb\n<!-- make_benchmarks: y -->\n<!-- end -->\n"
        once = bench_tables.with_section(text, "x", "new")
        self.assertEqual(once, text.replace("old", "new"))
        self.assertEqual(bench_tables.with_section(once, "x", "new"), once)
        self.assertIn("y -->\nmore\n<!-- end -->\n", bench_tables.with_section(once, "y", "more"))
        with self.assertRaises(ValueError):
            bench_tables.with_section(text, "z", "new")

    def test_times_of_kernels_are_brought_to_one_unit(self):
        table = bench_tables.kernels_table({"benchmarks": [{"name": "a", "cpu_time": 1500.0, "time_unit": "ns"},
                                                           {"name": "b", "cpu_time": 2.0, "time_unit": "ms", "triangles": 34523.0}]})
        self.assertIn("| a | 1.5 | – |", table)
        self.assertIn("| b | 2000 | triangles 3.45e+04 |", table)


def look(frames, cpu_ms, rss_mb=100.0):
    return {"frames": frames, "cpu_ms": cpu_ms, "rss_mb": rss_mb, "map_mb": 20.0, "file_mb": 3.0, "observed_voxels": 800000, "objects": 7, "ids_given": 1234,
            "stages_ms": {"register": 1.0, "integrate": 3.0, "fusion": 4.0}}


class Endurance(unittest.TestCase):
    def test_times_count_by_the_frames_that_they_are_of(self):
        self.assertAlmostEqual(bench_tables.weighted([look(300, 2.0), look(600, 4.0), look(700, 10.0)], lambda l: l["cpu_ms"]), 4.0)

    def test_a_building_is_a_row_with_bytes_per_observed_voxel_and_shares_of_stages(self):
        table = bench_tables.buildings_table([(8, {"looks": [look(300, 2.0)], "peak_rss_mb": 150.0})])
        self.assertIn("| 8 | 300 | 0.80 | 20 | 25.0 | 150 | 2.00 | 25 % | 0 % | 0 % | 75 % | 0 % | 0 % |", table)

    def test_homes_are_compared_with_the_first(self):
        line = bench_tables.homes_line({"looks": [look(300, 2.0), look(600, 4.0), look(900, 3.0), look(1200, 3.6)]}, 2)
        self.assertIn("takes 3.00 ms", line)
        self.assertIn("+10 %", line)

    def test_growth_is_counted_from_the_end_of_the_first_tenth(self):
        looks = [look(1000 * (i + 1), 2.0 if i < 10 else 3.0, 90.0 + i) for i in range(20)]
        line = bench_tables.endurance_line({"looks": looks})
        self.assertIn("From frame 2,000 to frame 20,000: process +18.0 MB", line)
        self.assertIn("+50 %", line)
        table = bench_tables.endurance_table({"looks": looks, "decoded_mb": 40.0}, rows=2)
        self.assertEqual(table.splitlines()[-1], "| 20,000 | 3.00 | 69 | 20.0 | 3.00 | 7 | 1,234 |")


class Charts(unittest.TestCase):
    def test_ticks_reach_the_largest_value_in_round_steps(self):
        self.assertEqual(svg_chart.ticks(7.3), [0, 2, 4, 6, 8])
        self.assertEqual(svg_chart.ticks(1), [0, 0.2, 0.4, 0.6, 0.8, 1])
        self.assertEqual(svg_chart.ticks(0), [0, 0.2])

    def test_points_lie_where_the_axes_say(self):
        svg = svg_chart.line_chart("times & sizes", "x", "ms", {"one": [(0, 0), (10, 10)]})
        root = xml.etree.ElementTree.fromstring(svg)
        circles = [(float(c.get("cx")), float(c.get("cy"))) for c in root.iter("{http://www.w3.org/2000/svg}circle")]
        bottom, top = svg_chart.HEIGHT - svg_chart.BOTTOM, svg_chart.TOP
        self.assertEqual(circles, [(svg_chart.LEFT, bottom), (svg_chart.WIDTH - svg_chart.RIGHT, top)])

    def test_refuses_to_draw_nothing(self):
        with self.assertRaises(ValueError):
            svg_chart.line_chart("t", "x", "y", {"one": []})


if __name__ == "__main__":
    unittest.main()
