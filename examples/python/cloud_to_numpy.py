"""Finds the nearest point of each cloud. x, y and z are arrays over the memory of the sample; nothing is copied.

    python3 cloud_to_numpy.py         # reads the topic 'points' of other programs
    python3 cloud_to_numpy.py --demo  # publishes it, too, and ends after 10 clouds
"""

import sys
import threading
import time

import numpy as np

import sft

POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4")])
FIELDS = [{"name": name, "offset": 4 * i, "datatype": 7, "count": 1} for i, name in enumerate(POINT.names)]


def scan(node):
    """Publishes random clouds until the node closes."""
    publisher = node.publisher("points", "sensor_msgs/PointCloud2")
    random = np.random.default_rng()
    while not node.is_interrupted:
        points = np.zeros((128, 1024), POINT)
        for axis in "xyz":
            points[axis] = random.uniform(-20, 20, points.shape)
        height, width = points.shape
        publisher.publish(header="auto", height=height, width=width, fields=FIELDS, point_step=POINT.itemsize,
                          row_step=width * POINT.itemsize, data=points.view(np.uint8))
        time.sleep(0.05)


def main():
    demo = "--demo" in sys.argv
    with sft.Node("nearest") as node:
        if demo:
            threading.Thread(target=scan, args=(node,), daemon=True).start()
        clouds = node.subscriber("points", fields="header.stamp, data{x,y,z}")
        for i, cloud in enumerate(clouds):
            x, y, z = cloud.columns("x", "y", "z")
            distance = np.sqrt(x * x + y * y + z * z)
            print(f"{distance.size} points {distance.shape}, the nearest {distance.min():.2f} m away")
            if demo and i == 10:
                break
    print("It ended well.")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
