"""Fixtures for all tests of the Python package. Each file of tests runs on an isolated host."""

import time

import numpy as np
import pytest

import sft

HANG_S = 60  # a wait that takes longer counts as failed


class Pair:
    """A publisher's node and a subscriber's node, which exchange samples by one path."""

    def __init__(self, transport):
        self.transport = transport
        self.nodes = [sft.Node(name, transport=transport, daemon_idle_exit=5) for name in ("a", "b")]

    def close(self):
        for node in self.nodes:
            node.close()

    def publisher(self, topic="t", type="sensor_msgs/PointCloud2", **options):
        return self.nodes[0].publisher(topic, type, **options)

    def open(self, fields="*", type="sensor_msgs/PointCloud2", topic="t", callback=None, **options):
        """Returns a publisher and a subscriber that are connected."""
        publisher = self.publisher(topic, type)
        subscriber = self.nodes[1].subscriber(topic, type, fields, callback, **options)
        assert publisher.wait_for_subscribers(1, HANG_S)
        return publisher, subscriber

    def send(self, message, fields="*", type="sensor_msgs/PointCloud2", **options):
        """Returns the sample that a subscriber gets of the message."""
        publisher, subscriber = self.open(fields, type, **options)
        publisher.publish(message)
        sample = subscriber.wait_for_sample(HANG_S)
        assert sample is not None
        kept.extend([publisher, subscriber])
        return sample


kept = []  # keeps what sent and received samples open until the test is over


@pytest.fixture(params=["shm", "udp"])
def pair(request):
    pair = Pair(request.param)
    yield pair
    kept.clear()
    pair.close()


@pytest.fixture
def node():
    with sft.Node("node", transport="udp") as node:
        yield node


def eventually(condition):
    """Returns whether the condition becomes true."""
    end = time.monotonic() + HANG_S
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.005)
    return True


FORMATS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}


def cloud(channels, height=1, width=100, step=None, slack=0, big=False, seed=1):
    """Returns a cloud of pseudo-random bytes; a channel is a tuple of name, offset, type and count."""
    ends = [offset + np.dtype(FORMATS[type]).itemsize * count for _, offset, type, count in channels]
    step = step or max(ends)
    row = width * step + slack
    data = np.random.default_rng(seed).integers(0, 256, height * row, np.uint8)
    fields = [dict(name=name, offset=offset, datatype=type, count=count) for name, offset, type, count in channels]
    return dict(header=dict(frame_id="lidar", stamp=dict(sec=7)), height=height, width=width, fields=fields,
                is_bigendian=big, point_step=step, row_step=row, data=data)


XYZI = [("x", 0, 7, 1), ("y", 4, 7, 1), ("z", 8, 7, 1), ("intensity", 12, 4, 1)]
