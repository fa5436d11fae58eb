"""The Python side of ./run bench tools. It prints its measurements as JSON. Times are in us.

    python_side.py take|points|loan COUNT BYTES

Copies are counted by address: all bytes of an array that is not in shared memory count as copied. The private memory
by which the process grows while it holds samples shows copies of any other kind.
"""

import json
import re
import sys
import time
import warnings

import numpy as np

import sft

CLOUD = "sensor_msgs/PointCloud2"
CHANNELS = [dict(name=name, offset=4 * i, datatype=7, count=1) for i, name in enumerate(["x", "y", "z", "intensity"])]
HELD = 4
clock = time.perf_counter_ns


def us_since(begin):
    return (clock() - begin) / 1000


def is_shared(array):
    """Returns true if the array is in shared memory."""
    address = array.__array_interface__["data"][0]
    with open("/proc/self/maps", encoding="utf-8") as maps:
        for line in maps:
            first, last = (int(end, 16) for end in line.split()[0].split("-"))
            if first <= address < last:
                return "/dev/shm/" in line
    return False


def copied_bytes(arrays):
    return sum(array.nbytes for array in arrays if not is_shared(array))


def private_bytes():
    with open("/proc/self/status", encoding="utf-8") as status:
        return 1024 * int(re.search(r"RssAnon:\s+(\d+)", status.read())[1])


def take(node, count, _):
    times = []
    with node.subscriber("cloud", CLOUD, "height, width") as subscriber:
        while len(times) < count and subscriber.wait(5):
            begin = clock()
            sample = subscriber.take()
            _ = sample.height * sample.width
            times.append(us_since(begin))
            del sample
    return dict(times=times)


def points(node, count, size):
    structured, columns, arrays = [], [], []
    with node.subscriber("cloud", CLOUD, "*") as subscriber:
        while len(structured) < count:
            sample = subscriber.wait_for_sample(5)
            begin = clock()
            xyz = sample.points("x", "y", "z")
            structured.append(us_since(begin))
            begin = clock()
            x, y, z = sample.columns("x", "y", "z")
            columns.append(us_since(begin))
            assert xyz.size == x.size == y.size == z.size == size // 48
            del sample, xyz, x, y, z
        before = private_bytes()
        while len(arrays) < 5 * HELD:
            sample = subscriber.wait_for_sample(5)
            arrays += [sample.points("x", "y", "z"), *sample.columns("x", "y", "z"), sample.data]
        grown = private_bytes() - before
        held = subscriber.held
    assert held == HELD
    return dict(points=structured, columns=columns, copied=copied_bytes(arrays), grown=grown, held=held * size)


def loan(node, count, size):
    warnings.simplefilter("error")  # a loan that is copied is a failure
    times = []
    pixels = np.full(size, 1, np.uint8)
    with node.publisher("cloud", CLOUD) as publisher:
        assert publisher.wait_for_subscribers(1, 20)
        while len(times) < count:
            begin = clock()
            with publisher.loan(for_overwrite=True, header=dict(frame_id="lidar_front"), height=1, width=size // 16,
                                fields=CHANNELS, point_step=16, row_step=size, data=size) as cloud:
                cloud.data[:] = pixels
            times.append(us_since(begin))
            time.sleep(0.002)
        with publisher.loan(for_overwrite=True, data=size) as cloud:
            copied = copied_bytes([cloud.data])
    return dict(times=times, copied=copied)


if __name__ == "__main__":
    with sft.Node("python", transport="shm") as the_node:
        print(json.dumps(dict(take=take, points=points, loan=loan)[sys.argv[1]](the_node, *map(int, sys.argv[2:]))))
