"""Tests that the dissector reads all traffic between the hosts of the demo, captured on the host of the publisher.

The demo is best effort and publishes one sample at a time: dissector_test.py has the other kinds of datagrams.
"""
import collections
import contextlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import unittest

import captures

DEMO = sys.argv.pop()
PUBLISHER = "10.77.0.5"
UNFRAGMENTED = "udp and ip[6:2] & 0x3fff = 0"  # SFT's datagrams are never fragmented by IP; those of Cyclone DDS may be
DATAGRAMS = 10000  # the limit of the capture: enough for the negotiation and two clouds


def networks_of(process):
    """Yields the paths of the network namespaces that a process holds open."""
    folder = pathlib.Path(f"/proc/{process.pid}/fd")
    for link in list(folder.iterdir()):
        try:
            if os.readlink(link).startswith("net:["):
                yield link
        except FileNotFoundError:
            pass


def has_address(network, address):
    shown = subprocess.run(["nsenter", f"--net={network}", "ip", "-o", "-4", "address"], capture_output=True, text=True)
    return f" {address}/" in shown.stdout


class DemoTest(unittest.TestCase):
    def network_of_publisher(self, demo):
        deadline = time.monotonic() + 10
        while time.monotonic() < deadline and demo.poll() is None:
            for network in networks_of(demo):
                if has_address(network, PUBLISHER):
                    return network
            with contextlib.suppress(subprocess.TimeoutExpired):
                demo.wait(0.02)
        demo.wait()
        print("SKIPPED: the demo has no network of its own here")
        self.skipTest("no namespaces")

    def capture(self, folder):
        pcap = folder / "demo.pcapng"
        with subprocess.Popen([DEMO, "--seconds", "10"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as demo:
            network = self.network_of_publisher(demo)
            subprocess.run(["nsenter", f"--net={network}", "dumpcap", "-q", "-i", "eth0", "-f", UNFRAGMENTED,
                            "-B", "64", "-c", str(DATAGRAMS), "-a", "duration:20", "-w", str(pcap)],
                           check=True, capture_output=True, timeout=30)
            demo.kill()  # the kernel then ends the demo's hosts, too
        return pcap

    def test_dissects_every_datagram(self):
        with tempfile.TemporaryDirectory() as folder:
            pcap = self.capture(pathlib.Path(folder))
            rows = captures.dissect(pcap, ["_ws.col.Protocol", "sft.kind", "sft.malformed", "_ws.malformed",
                                           "sft.leaves", "sft.total", "sft_heartbeat.process"])
        kinds = collections.Counter(row["sft.kind"] for row in rows)
        others = {row["_ws.col.Protocol"] for row in rows if not row["sft.kind"]}
        self.assertLessEqual(others, {"RTPS", "MDNS", "SFT heartbeat"}, "what is no sample is discovery")
        processes = {row["sft_heartbeat.process"] for row in rows if row["_ws.col.Protocol"] == "SFT heartbeat"}
        self.assertGreater(len(processes), 1, "several processes live")
        self.assertNotIn("", processes)
        self.assertEqual([row for row in rows if row["sft.malformed"] or row["_ws.malformed"]], [])
        self.assertGreater(kinds["1"], 0)
        self.assertGreater(kinds["2"], 100)
        self.assertGreater(kinds["8"], 0)
        self.assertGreater(kinds["9"], 0)
        self.assertGreater(kinds["12"], 0)
        self.assertTrue(any(row["sft.kind"] in ("1", "12") and re.match(r"\d", row["sft.leaves"]) for row in rows))


if __name__ == "__main__":
    unittest.main()
