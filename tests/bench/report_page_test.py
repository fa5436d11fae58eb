#!/usr/bin/env python3
"""Tests of the page that ./run bench all --report writes."""

import html.parser
import os
import sys
import unittest

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "bench"))

import report


def figure(value, unit="us", reference=None, **more):
    return {"name": "figure", "value": value, "unit": unit, "reference": reference,
            "ratio": None if reference is None else value / reference, **more}


class FigureTest(unittest.TestCase):
    def test_a_peer_with_a_shorter_time_or_a_higher_rate_is_ahead(self):
        self.assertTrue(report.is_behind(figure(3, "us", 2)))
        self.assertFalse(report.is_behind(figure(3, "GB/s", 2)))
        self.assertTrue(report.is_behind(figure(2, "GB/s", 3)))

    def test_nobody_is_ahead_without_a_reference_or_a_known_unit(self):
        self.assertIsNone(report.is_behind(figure(3)))
        self.assertIsNone(report.is_behind(figure(3, "furlongs", 2)))

    def test_a_bound_is_of_the_ratio_or_of_the_value_and_may_be_the_least(self):
        self.assertFalse(report.meets_bound(figure(3, reference=2, bound=1.2)))
        self.assertTrue(report.meets_bound(figure(3, reference=2, bound=5, bound_of="value")))
        self.assertFalse(report.meets_bound(figure(3, bound=5, bound_of="value", at_least=True)))
        self.assertIsNone(report.meets_bound(figure(3)))

    def test_numbers_have_four_digits_and_a_missing_one_is_a_dash(self):
        self.assertEqual([report.number(value) for value in (0, 12345.6, 1.23456, 0.012345, None, float("nan"))],
                         ["0", "12,346", "1.235", "0.01235", "–", "–"])


class PageTest(unittest.TestCase):
    class Reader(html.parser.HTMLParser):
        """Notes which tags are open, and what is outside of the page."""

        def __init__(self):
            super().__init__()
            self.open, self.sources = [], []

        def handle_starttag(self, tag, attributes):
            self.sources += [value for name, value in attributes if name in ("src", "href") and value[:1] != "#"]
            if tag not in ("meta", "rect", "line"):
                self.open.append(tag)

        def handle_endtag(self, tag):
            if tag not in ("rect", "line"):
                assert self.open.pop() == tag, tag

    def read(self, text):
        reader = self.Reader()
        reader.feed(text)
        reader.close()
        return reader

    def test_the_page_is_whole_and_needs_nothing_else(self):
        reader = self.read(report.page({"udp": [figure(3, "us", 2, bound=1.2), figure(4, "GB/s", 5), figure(None)]},
                                       [("command", "./run bench all")]))
        self.assertEqual((reader.open, reader.sources), ([], []))

    def test_what_is_behind_and_which_bounds_are_missed_is_said_above_the_table(self):
        text = report.section("udp", [figure(3, "us", 2, bound=1.2)])
        self.assertIn("The reference is better in: figure.", text)
        self.assertIn("Bounds that do not hold: figure.", text)

    def test_names_cannot_end_a_tag(self):
        text = report.page({"<b>": [figure(1, reference=2, reference_name="a < b")]}, [("commit", "<i>")])
        self.assertIn("a &lt; b", text)
        self.assertNotIn("<b>", text)
        self.assertNotIn("<i>", text)


if __name__ == "__main__":
    unittest.main()
