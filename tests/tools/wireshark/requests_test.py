"""Tests with captures of real nodes: the dissector explains datagrams by the requests that they answer."""
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import unittest

import captures

SFT = sys.argv.pop()
MESSAGE = "{ranges: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10], range_max: 2.5}"
SHAPE = "angle_min, angle_max, angle_increment, time_increment, "
# The selections of subscribers, and the text that the dissector shows for each: a part with the fields that it needs.
SELECTIONS = {
    "range_max": "range_max",
    "ranges[::4]": SHAPE + "ranges[::4]",
    "header.stamp, ranges[2:4]": "header.stamp, " + SHAPE + "ranges[2:4]",
    "range_max @ range_min < 3.2 and every 2nd": "range_max @ range_min < 3.2 and every 2nd",
    "ranges[5:] @ changed(range_max) or every 2nd at most 40 Hz":
        SHAPE + "ranges[5:] @ changed(range_max) or every 2nd",
}
WITHOUT_MEMORY = {**os.environ, "SFT_DAEMON": "/nonexistent"}  # makes all samples be sent as datagrams


class RequestsTest(unittest.TestCase):
    def setUp(self):
        if [name for _, name in socket.if_nameindex()] != ["lo"]:
            print("SKIPPED: this is not a host of its own")
            self.skipTest("no namespaces")

    def run_nodes(self, reliable):
        publish = [SFT, "pub", "scan", "sensor_msgs/LaserScan", MESSAGE, "--rate", "50"]
        with subprocess.Popen(publish + ["--reliable"] * reliable, stdout=subprocess.DEVNULL,
                              env=WITHOUT_MEMORY) as publisher:
            try:
                for fields in SELECTIONS:
                    subprocess.run([SFT, "echo", "scan", "--fields", fields, "-n", "3", "--timeout", "20"],
                                   check=True, stdout=subprocess.DEVNULL, timeout=40, env=WITHOUT_MEMORY)
            finally:
                publisher.terminate()

    def capture(self, folder):
        pcap = folder / "requests.pcapng"
        with subprocess.Popen(["dumpcap", "-i", "lo", "-f", "udp", "-a", "duration:100", "-w", str(pcap)],
                              stderr=subprocess.PIPE, text=True) as dump:
            try:
                while not dump.stderr.readline().startswith("File:"):
                    self.assertIsNone(dump.poll(), "dumpcap ended")
                for reliable in (False, True):
                    self.run_nodes(reliable)
            finally:
                dump.send_signal(signal.SIGINT)
                dump.communicate()
        return pcap

    def test_explains_each_datagram_of_real_nodes_by_its_request(self):
        with tempfile.TemporaryDirectory() as folder:
            rows = captures.dissect(self.capture(pathlib.Path(folder)), [
                "sft.mask", "sft.selection", "sft.asked_in", "sft_control.request.selection", "sft.malformed",
                "sft_control.malformed", "_ws.lua.error"])
        wrong = [row for row in rows if row["sft.malformed"] or row["sft_control.malformed"] or row["_ws.lua.error"]]
        self.assertEqual(wrong, [])
        explained = {row["sft.selection"] for row in rows if row["sft.mask"]}
        self.assertEqual(explained, set(SELECTIONS.values()))
        for row in rows:
            if row["sft.mask"]:
                request = rows[int(row["sft.asked_in"]) - 1]["sft_control.request.selection"]
                self.assertIn(row["sft.selection"], request)


if __name__ == "__main__":
    unittest.main()
