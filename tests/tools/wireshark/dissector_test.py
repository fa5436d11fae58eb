"""Tests of the Wireshark dissector on valid and invalid datagrams of every kind."""
import pathlib
import random
import struct
import tempfile
import unittest

import captures
from captures import (ack, channel, far, first, following, group, group_offer, group_probe, group_report, header,
                      heartbeat, history, mark, packed, rate, report, single, whole)


class DissectorTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.pcap = pathlib.Path(self.folder.name) / "capture.pcap"

    def tearDown(self):
        self.folder.cleanup()

    def read(self, payloads, fields, decode_as=False):
        captures.write_pcap(self.pcap, payloads)
        return captures.dissect(self.pcap, fields, decode_as)

    def test_reads_each_field_of_each_kind(self):
        words = struct.pack("<QQ", 0x5, 0x1)
        cases = [
            (first(), {"sft.version": "2", "sft.kind": "1", "sft.writer": "0x04030201", "sft.variant": "3",
                       "sft.sequence": "9", "sft.total": "4", "sft.mask": "0x0000000000000087",
                       "sft.leaves": "0-2, 7", "sft.payload": b"body".hex()}),
            (first(mask=0x1_0087), {"sft.mask": "0x0000000000010087", "sft.leaves": "0-2, 7, 16",
                                    "sft.flags.narrow_mask": "0", "sft.payload": b"body".hex()}),
            (first(flags=0x0E, marks=rate() + history() + channel()),
             {"sft.rate.period_us": "100000", "sft.rate.ordinal": "7", "sft.history.reader": "0x0000000100000002",
              "sft.history.oldest": "5", "sft.channel": "1", "sft.ordinal": "12", "sft.payload": b"body".hex()}),
            (first(flags=0x02, marks=rate()), {"sft.rate.period_us": "100000", "sft.leaves": "0-2, 7"}),
            (first(flags=0x02, marks=rate(period=0)),
             {"sft.rate.period_us": "0", "sft.rate.ordinal": "7", "sft.mask": "0x0000000000000087", "sft.leaves": ""}),
            (first(flags=0x0A, marks=rate(period=0) + channel()), {"sft.ordinal": "12", "sft.leaves": ""}),
            (first(flags=0x01, marks=words), {"sft.mask_word": "0x0000000000000005,0x0000000000000001",
                                              "sft.payload": b"body".hex()}),
            (first(flags=0xC0, marks=group()),
             {"sft.flags.group": "1", "sft.flags.merged": "1", "sft.group": "2", "sft.group.ordinal": "12",
              "sft.payload": b"body".hex()}),
            (first(flags=0x42, marks=rate(period=0) + group()),
             {"sft.rate.ordinal": "7", "sft.group": "2", "sft.group.ordinal": "12", "sft.leaves": "",
              "sft.payload": b"body".hex()}),
            (first(flags=0xC1, marks=group() + words), {"sft.group.ordinal": "12", "sft.payload": b"body".hex(),
                                                        "sft.mask_word": "0x0000000000000005,0x0000000000000001"}),
            (group_offer(), {"sft.kind": "6", "sft.group.port": "5000", "sft.group": "2", "sft.group.member": "1",
                             "sft.group.address": "239.255.16.2", "sft.channel": "4", "sft.group.ahead": "-5"}),
            (group_offer(address=0), {"sft.kind": "6", "sft.group.address": "0.0.0.0"}),
            (group_report(), {"sft.kind": "7", "sft.group": "2", "sft.group.member": "1", "sft.group.heard": "70"}),
            (group_report(heard=0), {"sft.kind": "7", "sft.group.heard": "0", "sft.malformed": ""}),
            (group_probe(), {"sft.kind": "11", "sft.group": "2", "sft.group.ordinal": "70"}),
            (following(), {"sft.kind": "2", "sft.writer": "0x04030201", "sft.variant": "3", "sft.offset": "1440",
                           "sft.sequence": "9", "sft.payload": b"more".hex()}),
            (following(variant=255, offset=0xFF_FFFF), {"sft.variant": "255", "sft.offset": str(0xFF_FFFF)}),
            (far(), {"sft.kind": "13", "sft.variant": "3", "sft.offset": str(1 << 24), "sft.sequence": "9",
                     "sft.payload": b"more".hex()}),
            (heartbeat(), {"sft.kind": "3", "sft.heartbeat.port": "5000", "sft.channel": "9",
                           "sft.heartbeat.first": "4", "sft.heartbeat.end": "9"}),
            (ack([(6, 0, 0), (8, 100, 200)]),
             {"sft.kind": "4", "sft.ack.parts": "2", "sft.ack.next": "6",
              "sft.missing.ordinal": "6,8", "sft.missing.begin": "0,100", "sft.missing.end": "0,200"}),
            (mark(), {"sft.kind": "8", "sft.flow": "67305985", "sft.flow.position": str(1 << 33),
                      "sft.flow.datagrams": "70"}),
            (report(), {"sft.kind": "9", "sft.report.window": "1048576", "sft.report.came": "69",
                        "sft.report.longest": "1472"}),
            (packed([b"abcd", b"efgh"], each=4, flags=0x08, marks=channel()),
             {"sft.kind": "5", "sft.packed.samples": "2", "sft.packed.bytes_each": "4", "sft.leaves": "0-1",
              "sft.payload": b"abcd".hex() + "," + b"efgh".hex(), "sft.sample.bytes": "4,4",
              "sft.ordinal": "12,12,13"}),
            (whole(variant=0x155, channel=0x2AA),
             {"sft.kind": "10", "sft.writer": "0x04030201", "sft.variant": str(0x155), "sft.channel": str(0x2AA),
              "sft.sequence": "9", "sft.ordinal": "12", "sft.total": "4", "sft.leaves": "0-2, 7", "sft.flags": "0x20",
              "sft.payload": b"body".hex()}),
            (whole(body=b"", flags=2, variant=1023, channel=2047, ordinal=0xFFFFFFFF),
             {"sft.flags.merged": "1", "sft.flags.mask_words": "0", "sft.variant": "1023", "sft.channel": "2047",
              "sft.ordinal": str(0xFFFFFFFF), "sft.total": "0"}),
            (whole(flags=1), {"sft.flags.mask_words": "1", "sft.flags.merged": "0", "sft.leaves": "", "sft.total": ""}),
            (single(flags=0x80),
             {"sft.kind": "12", "sft.writer": "0x04030201", "sft.variant": "3", "sft.sequence": "9", "sft.total": "4",
              "sft.leaves": "0-2, 7", "sft.flags.merged": "1", "sft.payload": b"body".hex()}),
            (single(body=b""), {"sft.kind": "12", "sft.total": "0", "sft.flags": "0x20"}),
            (single(mask=0x1_0087), {"sft.leaves": "0-2, 7, 16", "sft.flags": "0x00", "sft.payload": b"body".hex()}),
            (whole(mask=0x1_0087), {"sft.leaves": "0-2, 7, 16", "sft.flags": "0x00", "sft.payload": b"body".hex()}),
            (packed([b"abc", b"", b"d"], each=0, flags=0x10, padding=bytes(5)),
             {"sft.packed.samples": "3", "sft.sample.bytes": "3,0,1", "sft.padding": "0000000000"}),
        ]
        fields = sorted({field for _, expected in cases for field in expected} | {"sft.malformed"})
        rows = self.read([payload for payload, _ in cases], fields)
        self.assertEqual(len(rows), len(cases))
        for row, (payload, expected) in zip(rows, cases):
            with self.subTest(payload=payload.hex()):
                self.assertEqual({field: row[field] for field in expected}, expected)
                self.assertEqual(row["sft.malformed"], "")

    def test_says_what_is_wrong(self):
        wrong = [
            b"\x21" + bytes(10),
            header(1)[:12] + bytes(10),
            b"\x11" + first()[1:],
            header(9) + bytes(20),
            header(11) + bytes(20),
            b"\x1a" + whole()[1:],
            whole(ordinal=0),
            whole()[:25],
            single()[:21],
            single(flags=0x08),
            b"\x2c\x00" + single(mask=0x1_0087)[2:22] + b"\x00" + single(mask=0x1_0087)[23:],
            first(flags=0x10),
            first(total=2),
            first(flags=0x08, marks=channel(ordinal=0)),
            first(flags=0x40, marks=group(ordinal=0)),
            first(flags=0x48, marks=channel() + group()),
            first(flags=0x40)[:26],
            following(body=b""),
            far(body=b""),
            heartbeat(begin=9, end=4),
            heartbeat() + b"?",
            ack([(6, 5, 1)]),
            ack([(6, 0, 0)])[:-4],
            group_offer(address=0xE0000001),
            group_offer()[:-1],
            group_report() + b"?",
            group_probe()[:-1],
            group_probe(ordinal=0),
            packed([b"abcd"], each=4, flags=0x40),
            packed([], each=4),
            packed([b"abcd"], each=4)[:-1],
            packed([b"abcd"], each=4, padding=b"?"),
            packed([b"abcd"], each=4, flags=0x10),
            packed([b"abcd"], each=0, flags=0x10)[:-1],
        ]
        rows = self.read(wrong, ["sft.malformed", "_ws.lua.error", "_ws.col.Protocol"], decode_as=True)
        self.assertEqual(len(rows), len(wrong))
        for row, payload in zip(rows, wrong):
            with self.subTest(payload=payload.hex()):
                self.assertEqual(row["_ws.col.Protocol"], "SFT")
                self.assertNotEqual(row["sft.malformed"], "")
                self.assertEqual(row["_ws.lua.error"], "")

    def test_leaves_the_datagrams_of_others_alone(self):
        rng = random.Random(1)
        strangers = [rng.randbytes(rng.randrange(0, 300)) for _ in range(200)]
        strangers += [b"\x11" + first()[1:], first(flags=0x10), heartbeat() + b"?", packed([], each=4)]
        strangers += [whole(ordinal=0), whole()[:25], whole(stamp=-1), whole(stamp=5_000_000_000_000_000_000)]
        strangers += [following(writer=7), single()[:21], single(flags=0x01), single(stamp=-1)]
        strangers += [group_offer(address=0xE0000001), group_report() + b"?",
                      first(flags=0x48, marks=channel() + group())]
        rows = self.read(strangers, ["sft.kind"])
        taken = [row for row in rows if row["sft.kind"]]
        self.assertLessEqual(len(taken), 2)  # a few random datagrams begin with the right bytes by chance


if __name__ == "__main__":
    unittest.main()
