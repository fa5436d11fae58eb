"""Objects that programs open and close repeatedly must not leave memory, files or threads behind.

Each test does its work SFT_TEST_TIMES times as often as usual; ./run soak sets it.
"""

import collections
import gc
import os
import re
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import sft
from conftest import HANG_S, XYZI, cloud

TIMES = int(os.environ.get("SFT_TEST_TIMES", "1"))
MB = 1_000_000


def taken():
    """Returns the memory that the process shares with no other one, and the number of objects of Python."""
    gc.collect()
    private = re.search(r"RssAnon:\s+(\d+)", Path("/proc/self/status").read_text())[1]
    return 1024 * int(private), sys.getallocatedblocks()


def assert_flat(rounds, work, most_bytes=1 * MB):
    """Calls work(number) so many times. Neither the least memory nor the least number of objects may grow: what is only
    taken for a while does not raise the least."""
    window = rounds // 7
    early, late = [], []
    for number in range(rounds):
        work(number)
        if number % max(window // 10, 1) == 0 and number >= window:
            (early if number < 2 * window else late if number >= rounds - window else []).append(taken())
    bytes_grown, objects_grown = (min(after) - min(before) for before, after in zip(zip(*early), zip(*late)))
    assert bytes_grown < most_bytes
    assert objects_grown < 1000


def most_bytes(pair):
    """UDP keeps the buffers of the moment in which most samples waited for the other thread."""
    return (16 if pair.transport == "udp" else 1) * MB


def reliable_pair(pair, type):
    """Returns a publisher and a subscriber between which no sample is lost."""
    publisher = pair.publisher(type=type, reliable=True)
    subscriber = pair.nodes[1].subscriber("t", type, "*", reliable=True)
    assert publisher.wait_for_subscribers(1, HANG_S)
    return publisher, subscriber


def test_samples_and_arrays_are_kept_and_dropped(pair):
    publisher, subscriber = reliable_pair(pair, "sensor_msgs/PointCloud2")
    message = sft.find_type("sensor_msgs/PointCloud2")(**cloud(XYZI))
    some = collections.deque(maxlen=20)
    keeps = [lambda sample: sample, lambda sample: sample.data, lambda sample: sample.points("x", "y"),
             lambda sample: sample.columns("z"), lambda sample: sample.fields, lambda sample: sample.copy(),
             lambda sample: memoryview(sample.data), lambda sample: sample.header.stamp]

    def work(number):
        publisher.publish(message)
        some.append(keeps[number % len(keeps)](subscriber.wait_for_sample(HANG_S)))

    assert_flat(10_000 * TIMES, work, most_bytes(pair))
    some.clear()
    assert subscriber.held == 0


def test_loans_are_published_given_back_and_copied(pair):
    publisher, subscriber = reliable_pair(pair, "sensor_msgs/Image")
    pixels = np.arange(2000) % 256

    def work(number):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # every third loan is copied, since `data` still refers to it
            loan = publisher.loan(header="auto", height=1, encoding="mono8", data=len(pixels))
            loan.data[:] = pixels
            data = loan.data if number % 3 == 1 else None
            loan.discard() if number % 3 == 2 else loan.publish()
            del data
        if number % 3 != 2:
            assert len(subscriber.wait_for_sample(HANG_S).data) == len(pixels)

    assert_flat(10_000 * TIMES, work, most_bytes(pair))


def test_what_is_refused_leaves_nothing(node):
    publisher, subscriber = node.publisher("t", "sensor_msgs/Image"), node.subscriber("t", "sensor_msgs/Image")

    def work(_):
        for refused in (lambda: publisher.publish(height=-1), lambda: publisher.publish(hieght=1),
                        lambda: publisher.loan(data=10**9), lambda: publisher.publish(data="text"),
                        lambda: subscriber.set_selection("hieght"), lambda: sft.type_from_msg("a/B", "int33 a")):
            with pytest.raises((sft.Error, TypeError, ValueError)):
                refused()

    assert_flat(2000 * TIMES, work)


def test_services_are_called(pair):
    with pair.nodes[1].service("lights", "std_srvs/SetBool", lambda request: dict(success=request.data)), \
            pair.nodes[0].client("lights", "std_srvs/SetBool") as lights:
        def work(number):
            assert lights.call(data=number % 2 == 0, timeout=HANG_S).success == (number % 2 == 0)

        assert_flat(1000 * TIMES, work, most_bytes(pair))


@pytest.mark.parametrize("transport", ["shm", "udp"])
def test_nodes_are_opened_and_closed(transport):
    def counts():
        return len(os.listdir("/proc/self/fd")), len(os.listdir("/proc/self/task"))

    def work(number):
        with sft.Node("node", transport=transport, daemon_idle_exit=5, log=lambda *_: None) as node:
            got = []
            subscriber = node.subscriber("t", "sensor_msgs/Image", callback=got.append, on_event=lambda _: None)
            publisher = node.publisher("t", "sensor_msgs/Image")
            publisher.publish(data=bytes(1000))
            assert subscriber.held <= 1
        if number == 5:
            first.append(counts())

    first = []
    assert_flat(35 * TIMES, work, 6 * MB)
    files, threads = counts()
    assert files <= first[0][0] + 2 and threads <= first[0][1] + 1
