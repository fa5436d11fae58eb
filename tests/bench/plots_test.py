#!/usr/bin/env python3
"""Tests of the plots of docs/performance.md, and of what ./run bench all keeps for them."""

import os
import re
import sys
import tempfile
import unittest
import xml.etree.ElementTree

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "bench"))

import plots
import records
import svg


def figure(value, unit="us", reference=None, **more):
    return {"name": "figure", "value": value, "unit": unit, "reference": reference,
            "ratio": None if reference is None else value / reference, **more}


PLOTS = ["bytes", "latency_hosts", "latency_memory", "throughput", "isolation_readers", "isolation_publish",
         "growth"]
AXES = {"bytes": "bytes", "latency_hosts": "us", "latency_memory": "us", "throughput": "GB/s",
        "isolation_readers": "ms", "isolation_publish": "ms", "growth": "B/s"}


def named(name, value, reference=None):
    return {**figure(value, reference=reference), "name": name}


def everything():
    """Returns figures for each plot, in which SFT is better than all others."""
    whole = records.Records()
    whole.figures["paper"] = [named(name + end, 100, 200) for name, _ in plots.MESSAGES for end in ("", "_vs_fast_dds")]
    whole.figures["udp"] = [named(name + end, value, reference) for name, value, reference, ends in (
        ("bulk_4MiB", 6, 5, ("_reliable", "_vs_cyclone", "_vs_fast_dds")),
        ("cpu_per_GB", 1, 2, ("", "_vs_cyclone", "_vs_fast_dds"))) for end in ends]
    whole.figures["isolation"] = [
        named(f"isolation_{situation}_{of}_p99{suffix}", *((2000, 1000) if contender == "SFT" else (9000, 3000)))
        for situation, _ in plots.SITUATIONS for of in ("local", "publish") for contender, suffix in plots.SUFFIXES]
    whole.figures["many"] = [named(f"growth_{nodes}_{cost}", nodes, 2 * nodes)
                             for nodes in (25, 50) for cost, _, _ in plots.COSTS]
    whole.figures["peers"] = [named("p50", 40, 50)]
    whole.tables["peers.csv"] = [
        {"group": group, "contender": contender, "bytes": str(size), "p50_us": "40" if "sft" in contender else "50",
         "p999_us": "300"} for group, contenders in (("inter_sleeping", plots.BETWEEN_HOSTS),
                                                     ("intra_sleeping", plots.WITHIN_HOST))
        for contender, _ in contenders for size in (16, 1 << 20)]
    whole.about = {name: {"command": f"./run bench {name}", "date": "2026-11-23", "processors": "2 x <Fast & Co>",
                          "system": "Linux"} for name in whole.figures}
    return whole


class PlotTest(unittest.TestCase):
    def drawn(self, whole):
        """Returns all texts of each plot, which must be well-formed XML."""
        texts = {}
        for plot in plots.all_plots(whole):
            root = xml.etree.ElementTree.fromstring(plot.svg())
            self.assertEqual(root.tag, "{http://www.w3.org/2000/svg}svg")
            texts[plot.name] = [element.text or "" for element in root.iter() if element.tag.endswith("}text")]
        return texts

    def captions(self, whole):
        return {plot.name: plot.caption for plot in plots.all_plots(whole)}

    def test_each_plot_is_there_and_its_axes_have_units(self):
        texts = self.drawn(everything())
        self.assertEqual(list(texts), PLOTS)
        for name, unit in AXES.items():
            with self.subTest(name):
                self.assertTrue(any(re.search(rf"(^|[ ,]){unit}( |,|$)", text) for text in texts[name]), texts[name])

    def test_a_plot_says_machine_and_date_and_brings_colours_for_the_dark(self):
        for plot in plots.all_plots(everything()):
            text = plot.svg()
            for words in ("2026-11-23", "2 x &lt;Fast &amp; Co&gt;", "prefers-color-scheme: dark", "viewBox="):
                self.assertIn(words, text)
            self.assertNotRegex(re.sub("<style>.*?</style>", "", text, flags=re.DOTALL), "#[0-9a-f]{6}")

    def test_nothing_lies_outside_of_the_picture(self):
        whole = everything()
        whole.figures["isolation"][0]["value"] = 1e9
        whole.tables["peers.csv"][0]["p999_us"] = "0.001"
        for plot in plots.all_plots(whole):
            root = xml.etree.ElementTree.fromstring(plot.svg())
            _, _, width, height = map(float, root.get("viewBox").split())
            for element in root.iter():
                for names, end in ((("x", "x1", "x2", "cx"), width), (("y", "y1", "y2", "cy"), height)):
                    for name in names:
                        self.assertTrue(0 <= float(element.get(name, 0)) <= end, (plot.name, element.attrib))
                self.assertGreaterEqual(float(element.get("width", 0)), 0)

    def test_longer_bars_stand_for_larger_values(self):
        part = svg.bars([("a", [("SFT", 3), ("TCP", 30), ("UDP", 300)])], "us")
        widths = [float(width) for width in re.findall(r'<rect [^>]*width="([\d.]+)"', "".join(part.elements))]
        self.assertEqual(widths, sorted(widths))
        self.assertAlmostEqual(widths[1] - widths[0], widths[2] - widths[1], delta=0.2)

    def test_a_value_that_is_no_number_has_no_bar(self):
        part = svg.bars([("a", [("SFT", float("inf")), ("TCP", 30), ("UDP", float("nan")), ("iceoryx", None)])], "us")
        text = "".join(part.elements)
        self.assertEqual((text.count("<rect "), text.count(">no value<")), (1, 3))

    def test_where_sft_is_better_the_caption_says_so(self):
        for name, caption in self.captions(everything()).items():
            with self.subTest(name):
                self.assertNotIn("A peer is better", caption)

    def test_a_peer_that_is_better_or_alone_has_a_value_is_named(self):
        whole = everything()
        whole.figures["udp"][0].update(value=4, reference=5)
        whole.figures["many"][-1].update(value=None)
        whole.tables["peers.csv"] = [{**row, "p50_us": "30"} if row["contender"] == "tcp" else row
                                     for row in whole.tables["peers.csv"]]
        captions = self.captions(whole)
        self.assertIn("A peer is better in: throughput (UDP, GSO: 5.00 GB/s, SFT: 4.00 GB/s)", captions["throughput"])
        self.assertIn("50 nodes (Cyclone DDS: 100 B/s, SFT has no value)", captions["growth"])
        self.assertIn("1 MiB (TCP: 30.0 us, SFT, all data: 40.0 us)", captions["latency_hosts"])

    def test_a_lead_of_two_fields_hides_no_peer_that_sends_all_data_faster(self):
        whole = everything()
        for row in whole.tables["peers.csv"]:
            if row["contender"] == "sft_full":
                row["p50_us"] = "60"
        self.assertIn("A peer is better in: 16 B", self.captions(whole)["latency_hosts"])

    def test_without_figures_there_is_no_plot(self):
        self.assertEqual(plots.all_plots(records.Records()), [])
        self.assertEqual(plots.all_plots(records.Records({"udp": [figure(3)], "many": [{"name": None}]})), [])

    def test_any_figure_may_be_missing_or_no_number(self):
        for replacement in (None, float("nan"), float("inf"), 0, -1, "7"):
            for bench in everything().figures:
                for i in range(len(everything().figures[bench])):
                    whole = everything()
                    whole.figures[bench][i].update(value=replacement, reference=replacement)
                    self.drawn(whole)
        for name in everything().tables:
            for column in everything().tables[name][0]:
                for text in (None, "", "nan", "<b>", "-1", "1e308"):
                    whole = everything()
                    whole.tables[name][0][column] = text
                    self.drawn(whole)

    def test_hostile_texts_stay_texts(self):
        whole = everything()
        for about in whole.about.values():
            about["command"] = '</text><script>alert("1")</script>'
        whole.tables["peers.csv"][0]["contender"] = "<script>"
        for plot in plots.all_plots(whole):
            self.assertNotIn("<script", plot.svg())
        self.drawn(whole)


class RecordsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def test_what_is_kept_is_loaded_and_other_benchmarks_stay(self):
        with tempfile.TemporaryDirectory() as written:
            (option, path) = records.options_for_files("peers", {"--csv"}, written)
            with open(path, "w", encoding="utf-8") as file:
                file.write("ms,bytes\n1,2\n")
            records.keep(self.folder, "peers", [figure(1)], {"date": "today"}, written)
        records.keep(self.folder, "udp", [figure(2)], {"date": "tomorrow"}, self.folder)
        loaded = records.load(self.folder)
        self.assertEqual(option, "--csv")
        self.assertEqual(loaded.tables, {"peers.csv": [{"ms": "1", "bytes": "2"}]})
        self.assertEqual((loaded.figure("peers", "figure")["value"], loaded.figure("udp", "figure")["value"]), (1, 2))
        self.assertEqual(loaded.about["udp"], {"date": "tomorrow"})
        self.assertEqual(sorted(os.listdir(self.folder)), ["about.json", "peers.csv", "peers.json", "udp.json"])
        self.assertEqual(list(records.load(self.folder, ["udp"]).figures), ["udp"])

    def test_a_benchmark_without_the_option_writes_no_further_files(self):
        self.assertEqual(records.options_for_files("peers", set(), self.folder), [])
        self.assertEqual(records.options_for_files("udp", {"--csv"}, self.folder), [])


if __name__ == "__main__":
    unittest.main()
