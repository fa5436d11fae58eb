"""Tests of the Wireshark dissector on requests of subscribers, valid and invalid, and on datagrams that answer them."""
import pathlib
import random
import re
import struct
import tempfile
import unittest

import captures
from captures import first, rate, single, whole
from control_samples import (NOTHING, VERSION, WHOLE, announcement, condition, description, every, fnv, fragments,
                             heartbeat, inquiry, joined, key, leb, member, name_of, part, period, publisher, real,
                             record, request, sample, selection, short_text, subscriber, want)

ROOT = captures.SCRIPT.parents[2]
KNOWN_TYPE = description([member("sec", kind=7), member("frame", kind=13)],
                         [member("header", kind=14, struct_number=0),
                          member("points", kind=14, shape=2, struct_number=0),
                          member("ranges", shape=2), member("limit")])
READER = 0x1122334455667788


class ControlTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.pcap = pathlib.Path(self.folder.name) / "capture.pcap"

    def tearDown(self):
        self.folder.cleanup()

    def read(self, datagrams, fields, preferences=()):
        captures.write_pcap(self.pcap, datagrams)
        rows = captures.dissect(self.pcap, fields + ["_ws.lua.error"], preferences=preferences)
        self.assertEqual([row for row in rows if row.pop("_ws.lua.error")], [])
        return rows

    def read_requests(self, wants, fields, before=(), leaves=(0, 1, 8), more=()):
        """Returns the fields that the dissector shows for requests. There is one request for each item of `wants`."""
        samples = [request(READER, leaves, wants=bytes_of) for bytes_of in wants]
        rows = self.read([announcement("sft_reader"), *before, *(sample("sft_reader", one) for one in samples), *more],
                         ["sft_control.malformed", *fields])
        return rows[1 + len(before):len(rows) - len(more)]

    def asked(self, wants, **more):
        row, = self.read_requests([wants], ["sft_control.request.selection"], **more)
        self.assertEqual(row["sft_control.malformed"], "")
        return row["sft_control.request.selection"]

    def test_shows_all_that_a_request_has(self):
        parts = [part(1, rows=(10, 20, 1), columns=(0, 639, 2), channels=["x", "y z"]),
                 part(8, columns=(3, 4, 1), rule=7)]
        wants = period(200000) + want(selection([0, 1, 8], parts, [every(3)], rate=10))
        expected = {
            "sft_control.request.sequence": "3", "sft_control.request.mask_word": "0x0000000000000103",
            "sft_control.kind": "1", "sft_control.want.period_us": "200000",
            "sft_control.want.leaves": "0-1, 8", "sft_control.want.part.leaf": "1,8",
            "sft_control.want.part.rows": "10:20", "sft_control.want.part.columns": ":639:2,3",
            "sft_control.want.part.channel": "x,y z", "sft_control.want.part.rule": "0x00000007",
            "sft_control.want.rate": "at most 100000 Hz", "sft_control.request.listening": "0x0000000000000005",
            "sft_control.request.selection":
                "leaves 0, leaf 1{x,y z}[rows 10:20, columns :639:2], leaf 8[3] @ every 3rd at most 5 Hz"}
        rows = self.read([announcement("sft_reader"),
                          sample("sft_reader", request(READER, [0, 1, 8], wants=wants, listening=[5]))],
                         [*expected, "sft_control.malformed"])
        self.assertEqual(rows[1], {**expected, "sft_control.malformed": ""})

    def test_shows_a_request_of_whole_fields(self):
        self.assertEqual(self.asked(WHOLE, leaves=[0, 1, 2, 8]), "leaves 0-2, 8")
        self.assertEqual(self.asked(WHOLE, leaves=[]), "no fields")

    def test_shows_ranges_as_the_text_of_selections_has_them(self):
        for columns, text in [((0, 0, 0), "[0:0]"), ((0, 0, 4), "[::4]"), ((5, 6, 1), "[5]"), ((2, 7, 1), "[2:7]"),
                              ((2, 0, 1), "[2:]"), ((0, 9, 4), "[:9:4]")]:
            with self.subTest(text):
                wants = want(selection([1], [part(1, columns=columns)]))
                self.assertEqual(self.asked(wants, leaves=[1]), "leaf 1" + text)

    def test_shows_channels_in_the_order_of_their_bytes(self):
        channels = ["B", "a", "a b", "\u00e4"]
        self.assertEqual(self.asked(want(selection([1], [part(1, channels=channels)])), leaves=[1]),
                         "leaf 1{B,a,a b,\u00e4}")

    def test_shows_conditions_as_the_text_of_selections_has_them(self):
        less = condition(2, [0], real(3.25))
        cases = [
            ([less], "leaf 0 < 3.25"),
            ([condition(2, [1], b"\x02" + leb(3), comparison=5)], "leaf 1 != -4"),
            ([condition(2, [1], b"\x01" + leb((1 << 64) - 1), comparison=3)], "leaf 1 >= 18446744073709551615"),
            ([condition(2, [1], real(0.1), comparison=1)], "leaf 1 <= 0.1"),
            ([condition(3, [0, 8], NOTHING)], "changed(leaf 0, leaf 8)"),
            ([condition(3, [0], b"\x01" + leb(5), percent=True)], "changed(leaf 0) 5%"),
            ([every(1)], "every 1st"), ([every(12)], "every 12th"), ([every(103)], "every 103rd"),
            ([condition(5, number=b"\x01" + leb(10_000_000))], "every 10 s"),
            ([condition(5, number=b"\x01" + leb(90_000_000))], "every 90 s"),
            ([condition(5, number=b"\x01" + leb(120_000_000))], "every 2 min"),
            ([condition(5, number=b"\x01" + leb(1500))], "every 1500 us"),
        ]
        rows = self.read_requests([want(selection([0], conditions=conditions)) for conditions, _ in cases],
                                  ["sft_control.request.selection"], leaves=[0])
        for row, (_, text) in zip(rows, cases):
            with self.subTest(text):
                self.assertEqual(row["sft_control.request.selection"], "leaves 0 @ " + text)

    def test_shows_the_words_between_conditions(self):
        # Conditions that `and` or `or` forms out of others count, too.
        less, more = condition(2, [0], real(3.25)), condition(2, [0], real(4.5), comparison=2)
        for tree, count, text in [(joined("and", less, more), 3, "leaf 0 < 3.25 and leaf 0 > 4.5"),
                                  (joined("or", joined("and", less, every(2)), more), 5,
                                   "leaf 0 < 3.25 and every 2nd or leaf 0 > 4.5"),
                                  (joined("and", joined("or", less, more), every(2)), 5,
                                   "(leaf 0 < 3.25 or leaf 0 > 4.5) and every 2nd")]:
            with self.subTest(text):
                data = b"\x02" + leb(1) + b"\x01" + leb(count) + tree
                self.assertEqual(self.asked(want(data), leaves=[0]), "leaves 0 @ " + text)

    def test_says_a_period_in_its_best_unit(self):
        for us, text in [(10_000, "at most 100 Hz"), (333_333, "at most one per 333333 us"),
                         (2_000_000, "at most one per 2 s"), (1500, "at most one per 1500 us")]:
            with self.subTest(text):
                self.assertEqual(self.asked(period(us), leaves=[0]), "leaves 0 @ " + text)

    def test_names_leaves_by_the_type_that_the_subscriber_announced(self):
        before = [sample("sft_reader", subscriber(READER, description=KNOWN_TYPE))]
        parts = [part(5, columns=(0, 0, 4))]
        cases = [(range(7), WHOLE, "*"),
                 ([0, 1, 3, 4], WHOLE, "header, points[]"),
                 ([1, 2, 3, 4, 6], WHOLE, "header.frame, points, limit"),
                 ([0, 5], want(selection([0, 5], parts, [condition(3, [0, 6])])),
                  "header.sec, ranges[::4] @ changed(header.sec, limit)"),
                 ([0, 6], want(selection([0, 6], [], [condition(3, [0, 6])])), "header.sec, limit @ changed"),
                 ([0, 6], want(selection([0, 6], [], [condition(3, [6])])), "header.sec, limit @ changed(limit)")]
        for leaves, wants, text in cases:
            with self.subTest(text):
                self.assertEqual(self.asked(wants, before=before, leaves=leaves), text)

    def test_reads_types_with_whatever_a_description_can_have(self):
        in_array = [member("state", kind=4, attributes=b"\x04\x00"), member("label", kind=13, attributes=b"\x02\x09")]
        all_of_it = b"\x19" + leb(300) + short_text("m") + short_text("rows=a columns=b")
        of_type = description(in_array, [member("cells", kind=14, shape=1, struct_number=0), member("gains", shape=1),
                                         member("ranges", shape=2, attributes=all_of_it)],
                              enumerations=[["OFF", "ON"]])
        before = [sample("sft_reader", subscriber(READER, description=of_type))]
        self.assertEqual(self.asked(WHOLE, before=before, leaves=[0, 2, 3]), "cells[].state, gains, ranges")
        self.assertEqual(self.asked(WHOLE, before=before, leaves=[0, 1, 3]), "cells, ranges")

    def test_shows_what_publishers_and_subscribers_announce(self):
        fields = ["sft_control.role", "sft_control.id", "sft_control.topic", "sft_control.type_name",
                  "sft_control.address.ipv4", "sft_control.address.port", "sft_control.history_depth",
                  "sft_control.revision", "sft_control.memory_failure", "sft_control.given_topic",
                  "sft_control.malformed"]
        rows = self.read([announcement("sft_writer"), announcement("sft_reader"),
                          sample("sft_writer", publisher(0x5566, KNOWN_TYPE, memory_failure="no rights",
                                                         given_topic="~/scan")),
                          sample("sft_reader", subscriber(READER))], fields)
        known = {"sft_control.topic": "scan", "sft_control.type_name": "pkg::msg::Scan", "sft_control.malformed": "",
                 "sft_control.address.ipv4": "10.0.0.1", "sft_control.address.port": "7000",
                 "sft_control.history_depth": "8", "sft_control.revision": "1"}
        self.assertEqual(rows[2], {**known, "sft_control.role": "0", "sft_control.id": "0x0000000000005566",
                                   "sft_control.memory_failure": "no rights", "sft_control.given_topic": "~/scan"})
        self.assertEqual(rows[3], {**known, "sft_control.role": "1", "sft_control.id": f"0x{READER:016x}",
                                   "sft_control.memory_failure": "", "sft_control.given_topic": ""})

    def test_shows_what_was_withdrawn(self):
        rows = self.read([announcement("sft_reader"), sample("sft_reader", record(0, b"", slot=7, revision=9)),
                          sample("sft_reader", key(slot=8), flags=0x09)],
                         ["sft_control.slot", "sft_control.kind", "sft_control.revision", "sft_control.malformed"])
        self.assertEqual(list(rows[1].values()), ["7", "0", "9", ""])
        self.assertEqual(list(rows[2].values()), ["8", "0", "", ""])

    def test_shows_inquiries(self):
        rows = self.read([announcement("sft_reader"), sample("sft_reader", inquiry("scan", True))],
                         ["sft_control.kind", "sft_control.topic", "sft_control.inquiry.wants_accounts",
                          "sft_control.malformed"])
        self.assertEqual(list(rows[1].values())[:2] + [rows[1]["sft_control.malformed"]], ["2", "scan", ""])
        self.assertIn(rows[1]["sft_control.inquiry.wants_accounts"], ("1", "True"))

    def test_shows_heartbeats_by_udp_and_by_their_topic(self):
        rows = self.read([heartbeat(0x1234), announcement("sft_heartbeat"),
                          sample("sft_heartbeat", heartbeat(0x5678)), heartbeat(0x9abc)[:-1]],
                         ["_ws.col.Protocol", "sft_heartbeat.process", "sft_heartbeat.version",
                          "sft_heartbeat.digest_of_readers"])
        self.assertEqual(list(rows[0].values()),
                         ["SFT heartbeat", "0x0000000000001234", str(VERSION), "0x0000000000000002"])
        self.assertEqual(rows[2]["sft_heartbeat.process"], "0x0000000000005678")
        self.assertEqual(rows[3]["sft_heartbeat.process"], "")

    def test_shows_each_of_several_samples_in_a_datagram(self):
        rows = self.read([announcement("sft_reader"),
                          sample("sft_reader", request(1, [0], wants=period(7)), request(2, [1]), subscriber(3))],
                         ["sft_control.request.selection", "sft_control.id", "sft_control.malformed"])
        self.assertEqual(rows[1]["sft_control.request.selection"], "leaves 0 @ at most one per 7 us,leaves 1")
        self.assertEqual(rows[1]["sft_control.id"], "0x0000000000000003")
        self.assertEqual(rows[1]["sft_control.malformed"], "")

    def test_says_what_is_wrong_with_selections(self):
        self.assert_malformed([want(data) for data in [
            b"\x01", b"\x08\x00", selection([0]) + b"?", b"\x00\x01\x00", b"\x00\x02\x01", b"\x00\x81\x00\x01", b"\x00",
            b"\x04\x00\x00", b"\x00" + b"\xff" * 9 + b"\x02"]])

    def test_says_what_is_wrong_with_parts(self):
        self.assert_malformed([want(selection([0, 1], parts)) for parts in [
            [part(2, columns=(0, 0, 2))], [part(1, columns=(0, 0, 2)), part(0, columns=(0, 0, 2))], [part(0)],
            [part(0, rule=5)], [part(0, columns=(0, 0, 1))], [part(0, columns=(5, 5, 1))], [part(0, columns=(3, 0, 0))],
            [part(0, columns=(0, 8, 4))], [part(0, columns=(5, 6, 2))], [part(0, channels=["b", "a"])],
            [part(0, channels=["a", "a"])], [part(0, channels=[""])], [b"\x04\x00\x00"], [b"\x10\x00"],
            [b"\x09\x00\x00\x00\x00\x02"], [b"\x01\x00\x00"], [b"\x01\xff\xff\xff\xff\x1f\x00\x00\x02"],
            [part(leaf, columns=(0, 0, 2)) for leaf in range(17)]]])

    def test_says_what_is_wrong_with_conditions(self):
        term = condition(2, [0], real(1.5))
        deep = term
        for depth in range(8):
            deep = joined(("and", "or")[depth % 2], deep, term)
        alone = [condition(6), condition(2, [0, 1]), condition(2, []), condition(2, [0], comparison=6),
                 condition(3, []), condition(3, [0], comparison=1), condition(2, [0], percent=True),
                 condition(4, [0], b"\x01\x02"),
                 condition(4, number=NOTHING), condition(4, number=real(1.5)), condition(5, number=NOTHING),
                 b"\x80" + term[1:], condition(2, [0], b"\x00"), condition(2, [0], b"\x04"),
                 condition(2, [0], b"\x02" + leb((1 << 64) - 1)), b"\x00\x02"]
        trees = [*((1, tree) for tree in alone), (0, b""), (2, term + term), (2, joined("and", term)),
                 (2, joined("and", term, term)), (3, joined("and", term)), (17, deep),
                 (33, joined("and", *[term] * 32))]
        self.assert_malformed([want(b"\x02\x01\x01" + leb(count) + tree) for count, tree in trees])

    def assert_malformed(self, wants):
        rows = self.read_requests(wants, ["sft_control.request.selection"])
        for row, bytes_of in zip(rows, wants):
            with self.subTest(wants=bytes_of.selection_bytes.hex()):
                self.assertNotEqual(row["sft_control.malformed"], "")
                self.assertEqual(row["sft_control.request.selection"], "")

    def test_says_what_is_wrong_with_samples(self):
        whole_one = request(READER, [0], wants=want(selection([0])))
        body = whole_one[36:]
        wrong = [whole_one[:-4], whole_one + bytes(8), request(READER, [0], version=VERSION + 1),
                 record(3, body), record(1, body[:-1]), record(1, body + b"?"), record(1, bytes(8) + body[8:]),
                 record(1, body[:16] + struct.pack("<I", 1 << 30) + bytes(8)),
                 record(0, body), record(2, b"\x05scan"), record(2, b"\x04scan\0\0"), subscriber(0),
                 publisher(5, b"\x02" + KNOWN_TYPE[1:]),
                 publisher(5, KNOWN_TYPE + b"?"), publisher(5, KNOWN_TYPE[:-3]), publisher(5, description()),
                 publisher(5, description([member("a", kind=15)])), publisher(5, description([member("a", shape=3)])),
                 publisher(5, description([member("a", kind=14, struct_number=0)])),
                 publisher(5, description(*[[member("a", kind=14, struct_number=max(i - 1, 0)) if i else member("a")]
                                            for i in range(70)])),
                 publisher(5, description(*[[member("a"), member("b")] if i == 0 else
                                            [member(name, kind=14, struct_number=i - 1) for name in "ab"]
                                            for i in range(20)]))]
        rows = self.read([announcement("sft_reader"), *(sample("sft_reader", one) for one in wrong)],
                         ["sft_control.malformed"])
        for row, payload in zip(rows[1:], wrong):
            with self.subTest(payload=payload.hex()):
                self.assertNotEqual(row["sft_control.malformed"], "")

    def test_stands_samples_whose_bytes_were_altered(self):
        rng = random.Random(1)
        parts = [part(1, rows=(1, 9, 4), channels=["x"])]
        wants = period(7) + want(b"\x03" + selection([1], parts)[1:] + leb(3) + joined("and", every(2), every(3)))
        altered = []
        sound = [subscriber(READER, description=KNOWN_TYPE), request(READER, [1], wants=wants)]
        for one in sound * 150:
            data = bytearray(one)
            for _ in range(rng.randrange(1, 4)):
                data[rng.randrange(len(data))] = rng.choice([0, 1, 0x7F, 0x80, 0xFF, rng.randrange(256)])
            altered.append(bytes(data[:rng.choice([len(data), len(data), rng.randrange(len(data))])]))
        rows = self.read([announcement("sft_reader"), *(sample("sft_reader", one) for one in altered)],
                         ["sft_control.malformed"])
        self.assertEqual(len(rows), 1 + len(altered))
        self.assertGreater(sum(row["sft_control.malformed"] != "" for row in rows), 100)

    def test_reads_samples_whose_topic_was_announced_before_the_capture(self):
        samples = [publisher(0x55, KNOWN_TYPE), subscriber(READER), request(READER, [1], wants=period(5000))]
        topics = ["sft_writer", "sft_reader", "sft_reader"]
        rows = self.read([sample(topic, one) for topic, one in zip(topics, samples)],
                         ["sft_control.version", "sft_control.want.period_us", "sft_control.malformed"])
        self.assertEqual([row["sft_control.version"][:2] for row in rows], [str(VERSION)] * 3)
        self.assertEqual(rows[2]["sft_control.want.period_us"], "5000")
        self.assertEqual([row["sft_control.malformed"] for row in rows], [""] * 3)

    def test_reads_samples_in_fragments_if_wireshark_reassembles_them(self):
        wants = period(200000) + want(selection([0, 1], [part(1, columns=(0, 0, 4))]))
        pieces = fragments("sft_reader", request(READER, [0, 1], wants=wants), 48)
        fields = ["sft_control.request.selection", "sft_control.malformed"]
        for before in ([announcement("sft_reader")], []):
            for reassembles, text in (("TRUE", "leaves 0, leaf 1[::4] @ at most 5 Hz"), ("FALSE", "")):
                rows = self.read([*before, *pieces], fields, ["rtps.enable_rtps_reassembly:" + reassembles])
                self.assertEqual([row["sft_control.malformed"] for row in rows], [""] * len(rows))
                texts = [row["sft_control.request.selection"] for row in rows]
                self.assertEqual(texts, [""] * (len(rows) - 1) + [text])

    def test_leaves_the_samples_of_other_topics_alone(self):
        rng = random.Random(1)
        strangers = [rng.randbytes(rng.randrange(0, 300)) for _ in range(200)]
        strangers += [request(READER, [1], version=VERSION + 1), key(), bytes(100), record(3, b"?"),
                      request(READER, [1])[:-4], request(READER, [1]) + bytes(4)]
        rows = self.read([sample("chatter", one) for one in strangers], ["sft_control.version", "sft_control.reader"])
        self.assertEqual([row for row in rows if row["sft_control.version"] or row["sft_control.reader"]], [])
        rows = self.read([announcement("chatter"), *(sample("chatter", one) for one in strangers)], ["sft_control.id"])
        self.assertEqual([row for row in rows if row["sft_control.id"]], [])

    def test_leaves_samples_alone_that_are_not_little_endian_cdr(self):
        big = bytes(16) + struct.pack(">IBBHQI", 1, 0, VERSION, 0, 1, 0)
        rows = self.read([announcement("sft_reader"), sample("sft_reader", big, encapsulation=bytes(4))],
                         ["sft_control.reader", "sft_control.malformed"])
        self.assertEqual(rows[1], {"sft_control.reader": "", "sft_control.malformed": ""})

    def test_knows_the_version_of_the_control_topics(self):
        def version_in(path, pattern):
            return re.search(pattern, (ROOT / path).read_text())[1]

        version = version_in("core/control/sft_control.idl", r"protocol_version = (\d+);")
        self.assertEqual(version_in("tools/wireshark/sft.lua", r"control_version = (\d+)\n"), version)
        self.assertEqual(str(VERSION), version)

    # Datagrams of captures with and without their requests.

    def read_mask(self, datagram, before=()):
        """Returns the meaning of the mask, its leaves, the request, and the frame of the request."""
        fields = ["sft.mask.meaning", "sft.leaves", "sft.selection", "sft.asked_in"]
        row = self.read([announcement("sft_reader"), announcement("sft_writer"), *before, datagram],
                        [*fields, "sft.malformed"])[-1]
        self.assertEqual(row["sft.malformed"], "")
        return tuple(row[field] for field in fields)

    def test_explains_the_hash_of_parts_by_the_request(self):
        one_part = part(5, columns=(0, 0, 4))
        asks = [sample("sft_reader", subscriber(READER, description=KNOWN_TYPE)),
                sample("sft_reader", request(READER, [0, 5], wants=want(selection([0, 5], [one_part]))))]
        name = name_of(0x21, parts=b"\x01" + one_part)
        for datagram in (first(mask=name), single(mask=name), whole(mask=name)):
            self.assertEqual(self.read_mask(datagram, asks),
                             ("hash of a selection with parts", "", "header.sec, ranges[::4]", "4"))

    def test_explains_the_hash_of_conditions_by_the_request(self):
        term, one_part = every(2), part(5, columns=(0, 0, 4))
        for parts, kind, text in [([one_part], "parts and conditions", "leaf 5[::4] @ every 2nd"),
                                  ([], "conditions", "leaves 5 @ every 2nd")]:
            wants = period(9) + want(selection([5], parts, [term]))
            name = name_of(0x20, parts=parts and b"\x01" + one_part, conditions=b"\x01" + term)
            self.assertEqual(self.read_mask(first(mask=name, flags=0x02, marks=rate()),
                                            [sample("sft_reader", request(READER, [5], wants=wants))]),
                             ("hash of a selection with " + kind, "", text, "3"))

    def test_prefers_the_request_of_a_subscriber_whose_type_it_knows(self):
        asks = [sample("sft_reader", one) for one in (
            request(READER, [6]), request(READER, [6]), subscriber(READER, description=KNOWN_TYPE),
            request(READER, [6]), request(READER + 1, [6]))]
        self.assertEqual(self.read_mask(first(mask=0x40), asks), ("leaves", "6", "limit", "6"))
        self.assertEqual(self.read_mask(first(mask=0x40), asks[:2]), ("leaves", "6", "leaves 6", "3"))

    def test_explains_a_mask_by_a_request_of_the_same_topic(self):
        other = [sample("sft_reader", subscriber(READER, description=KNOWN_TYPE, topic="other")),
                 sample("sft_reader", request(READER, [6]))]
        same = [sample("sft_reader", subscriber(READER + 1, topic="scan")),
                sample("sft_reader", request(READER + 1, [6]))]
        here = sample("sft_writer", publisher(0x0504030201))
        there = sample("sft_writer", publisher(0x0504030201, topic="other"))
        unknown = [sample("sft_reader", request(READER + 2, [6]))]
        for before, selection_shown, frame in [
                ([here, *other, *same], "leaves 6", "7"), ([there, *other, *same], "limit", "5"),
                ([here, *other], "", ""), ([here, *other, *unknown], "leaves 6", "6"),
                ([*other, *same], "limit", "4")]:
            with self.subTest(frame=frame):
                shown = self.read_mask(first(mask=0x40), before)
                self.assertEqual(shown[2:], (selection_shown, frame))

    def test_explains_no_union_by_a_request_that_has_the_same_number(self):
        asks = [sample("sft_reader", request(READER, [6]))]
        self.assertEqual(self.read_mask(first(mask=0x40, flags=0x80), asks), ("leaves", "6", "", ""))

    def test_computes_the_hashes_that_publishers_write(self):
        # These bytes and hashes are from datagrams of real nodes.
        of_conditions = "020200020601030002020103039a999999999909402a01090203430109010105000180ade204"
        for mask, asked, name in [(0x47B, "01027b0401020a000004", 0xDDC26ED7D98DE513),
                                  (0x200, of_conditions, 0x66CE3D99D64E73B1)]:
            leaves = [leaf for leaf in range(64) if mask >> leaf & 1]
            row, = self.read_requests([want(bytes.fromhex(asked))], ["sft_control.request.name"], leaves=leaves)
            self.assertEqual(row["sft_control.request.name"], f"0x{name:016x}")

    def test_shows_the_leaves_of_a_mask_that_was_asked_for(self):
        asks = [sample("sft_reader", request(READER, [0, 1, 2, 7]))]
        self.assertEqual(self.read_mask(first(), asks), ("leaves", "0-2, 7", "leaves 0-2, 7", "3"))

    def test_explains_the_hash_of_a_long_mask_by_the_request(self):
        asks = [sample("sft_reader", request(READER, [0, 1, 70], words=2))]
        name = fnv(struct.pack("<QQ", 0x3, 1 << 6))
        for datagram in (first(mask=name), first(mask=name, flags=0x01, marks=struct.pack("<QQ", 0x3, 1 << 6))):
            self.assertEqual(self.read_mask(datagram, asks), ("hash of a mask", "0-1, 70", "leaves 0-1, 70", "3"))

    def test_shows_no_leaves_where_the_number_looks_like_a_hash(self):
        name = name_of(0x21, parts=b"\x01" + part(5, columns=(0, 0, 4)))
        self.assertEqual(self.read_mask(first(mask=name)),
                         ("it looks like the hash of a selection with parts", "", "", ""))
        self.assertEqual(self.read_mask(first(mask=name, flags=0x02, marks=rate())),
                         ("it looks like the hash of a selection with parts or conditions", "", "", ""))
        self.assertEqual(self.read_mask(first(mask=name, flags=0x02, marks=rate(period=0))),
                         ("hash of a selection with conditions", "", "", ""))

    def test_shows_the_leaves_of_a_union_whatever_the_number_looks_like(self):
        name = name_of(0x21, parts=b"\x01" + part(5, columns=(0, 0, 4)))
        meaning, leaves, _, _ = self.read_mask(first(mask=name, flags=0x80))
        self.assertEqual(meaning, "leaves")
        self.assertGreater(leaves.count(","), 5)

    def test_shows_leaves_where_the_number_does_not_look_like_a_hash(self):
        unless = "leaves, unless it is the hash of a selection with parts"
        for mask, leaves in [(0x87, "0-2, 7"), ((1 << 64) - 1, "0-63"), (1 << 63, "63")]:
            self.assertEqual(self.read_mask(first(mask=mask)), (unless, leaves, "", ""))

    def test_tells_by_the_type_of_the_publisher_what_is_a_hash(self):
        def of_type(leaves, writer=0x0504030201):
            return [sample("sft_writer", publisher(writer, description([member(f"f{i}") for i in range(leaves)])))]

        parts, unless = "hash of a selection with parts", "leaves, unless it is the hash of a selection with parts"
        for before, mask, meaning in [
                (of_type(7), 0x41, "leaves"), (of_type(7), 0x87, parts), (of_type(64), 0x87, unless),
                (of_type(70), 0x41, parts), (of_type(7) + of_type(8, writer=0x0604030201), 0x87, unless),
                (of_type(7, writer=0x0504030202), 0x87, unless),
                ([sample("sft_reader", subscriber(0x0504030201, description=KNOWN_TYPE))], 0x87, unless)]:
            with self.subTest(meaning, mask=mask):
                self.assertEqual(self.read_mask(first(mask=mask), before)[0], meaning)


if __name__ == "__main__":
    unittest.main()
