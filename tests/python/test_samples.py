"""Samples in Python: absent fields, recorded fields, arrays over the sample's memory, points and pixels."""

import gc
import time
from pathlib import Path

import numpy as np
import pytest

import sft
from conftest import FORMATS, HANG_S, XYZI, cloud, eventually


def test_fields_are_attributes_and_paths(pair):
    sample = pair.send(cloud(XYZI))
    assert sample.header.frame_id == "lidar" and sample.header.stamp.sec == 7 and sample.width == 100
    assert [field.name for field in sample.fields] == ["x", "y", "z", "intensity"]
    assert sample.find("fields[3].offset") == 12 and sample.size("fields") == 4
    assert sample.info.transport == pair.transport and sample.info.sequence == 1
    with pytest.raises(AttributeError, match="did you mean 'width'"):
        sample.widht
    with pytest.raises(AttributeError, match="read-only"):
        sample.width = 3
    assert not hasattr(sample, "nothing")


def test_a_field_that_was_not_sent_is_absent_and_never_zero(pair):
    sample = pair.send(cloud(XYZI), "width", as_remote=True)
    assert sample.width == 100
    for absent in (sample.height, sample.data, sample.fields, sample.header.frame_id):
        assert isinstance(absent, sft.Absent)
    for use in (lambda: sample.height + 1, lambda: 1 + sample.height, lambda: bool(sample.height),
                lambda: sample.height == 0, lambda: sample.height < 1, lambda: len(sample.data), lambda: sample.data[0],
                lambda: list(sample.fields), lambda: f"{sample.height:.1f}", lambda: np.arange(3) + sample.height,
                lambda: np.asarray(sample.data), lambda: float(sample.height), lambda: sample.fields.name):
        with pytest.raises(sft.AbsentError, match="'(height|data|fields)' was not sent.*fields of the subscriber"):
            use()
    assert "height=<absent>" in repr(sample) and "height" not in str(sample)
    assert isinstance(sample.copy().height, sft.Absent)
    with pytest.raises(sft.AbsentError, match="height"):
        pair.send({"height": sample.height}, topic="other")


def test_a_subscriber_that_names_nothing_is_soon_sent_what_the_program_touches(pair):
    publisher, subscriber = pair.open(None, as_remote=True, narrow_after_samples=3)

    def next_sample():
        publisher.publish(cloud(XYZI))
        return subscriber.wait_for_sample(HANG_S)

    def narrowed():
        sample = next_sample()
        return sample.width == 100 and sample.header.stamp.sec == 7 and sample._is_absent("data")

    assert eventually(narrowed)
    assert subscriber.requested == "header.stamp.sec, width"
    height = next_sample().height
    with pytest.raises(sft.AbsentError, match="'height' was not sent.*it has been asked for"):
        height + 1
    assert eventually(lambda: not next_sample()._is_absent("height")) and "height" in subscriber.requested


def test_points_record_their_channels_only(pair):
    publisher, subscriber = pair.open(None, as_remote=True, narrow_after_samples=3)

    def narrowed():
        publisher.publish(cloud(XYZI))
        x, y = subscriber.wait_for_sample(HANG_S).columns("x", "y")
        return len(x) == 100 and "data{x,y}" in subscriber.requested.replace(" ", "")

    assert eventually(narrowed)


def is_in_shared_memory(array):
    address, maps = array.ctypes.data, Path("/proc/self/maps").read_text().splitlines()
    ends = [[int(end, 16) for end in line.split()[0].split("-")] for line in maps if "/dev/shm/" in line]
    return any(first <= address < last for first, last in ends)


def test_arrays_are_read_only_and_not_copied(pair):
    sample = pair.send(dict(cloud(XYZI), data=np.zeros(6_291_456, np.uint8)))
    data = sample.data
    assert data.ctypes.data == sample.data.ctypes.data and data.dtype == np.uint8 and len(data) == 6_291_456
    assert is_in_shared_memory(data) == (pair.transport == "shm")
    for write in (lambda: data.__setitem__(0, 1), lambda: data.setflags(write=True), lambda: data[3:5].fill(1),
                  lambda: data.reshape(2, -1).setflags(write=True), lambda: data.view("u4").__setitem__(0, 1),
                  lambda: memoryview(data).__setitem__(0, 1), lambda: np.frombuffer(data, np.uint8).fill(1),
                  lambda: np.from_dlpack(data).fill(1), lambda: np.ctypeslib.as_ctypes(data)):
        with pytest.raises((ValueError, TypeError, BufferError)):
            write()
    assert memoryview(data).readonly and bytes(data[:2]) == b"\0\0"
    assert np.from_dlpack(data.copy()).sum() == 0


def test_an_array_keeps_its_sample_and_nothing_else_does(pair):
    publisher, subscriber = pair.open()
    for i in range(40):
        publisher.publish(dict(cloud(XYZI), width=i))
        array = subscriber.wait_for_sample(HANG_S).data
        assert subscriber.held == 1
    view = array[5:]
    del array
    gc.collect()
    assert subscriber.held == 1 and view[0] == cloud(XYZI)["data"][5]
    del view
    assert subscriber.held == 0
    publisher.publish(cloud(XYZI))
    mine = subscriber.wait_for_sample(HANG_S).copy()
    assert subscriber.held == 0 and mine.data[5] == cloud(XYZI)["data"][5]


def test_samples_that_a_program_keeps_harm_nobody_else(pair):
    publisher, subscriber = pair.open(max_held=4)
    other = pair.nodes[1].subscriber("t", "sensor_msgs/PointCloud2", "width")
    assert publisher.wait_for_subscribers(2, HANG_S)
    kept = []
    for i in range(20):
        publisher.publish(width=i)
        assert other.wait_for_sample(HANG_S).width == i
        kept.append(subscriber.take())
    kept = [sample for sample in kept if sample is not None]
    if pair.transport == "shm":
        assert subscriber.held == 4 == len(kept) and subscriber.status()["held_too_many"] > 0
    kept.clear()
    assert subscriber.take() is not None or pair.transport == "udp"


def test_samples_in_closures_tracebacks_and_cycles_are_held_until_these_are_gone(pair):
    publisher, subscriber = pair.open()

    def taken():
        publisher.publish(cloud(XYZI))
        return subscriber.wait_for_sample(HANG_S)

    def in_closure():
        sample = taken()
        return lambda: sample.width

    def in_traceback():
        sample = taken()
        try:
            raise RuntimeError(sample.width)
        except RuntimeError as error:
            return error

    def in_cycle():
        cycle = [taken().data]
        cycle.append(cycle)
        return cycle

    for keep in (in_closure, in_traceback, in_cycle, lambda: {"cell": taken().fields}):
        kept = keep()
        assert subscriber.held == 1
        del kept
        gc.collect()
        assert subscriber.held == 0


def test_samples_outlive_their_subscriber_and_node():
    with sft.Node("short") as node:
        publisher = node.publisher("t", "sensor_msgs/PointCloud2")
        subscriber = node.subscriber("t", "sensor_msgs/PointCloud2", "*")
        assert publisher.wait_for_subscribers(1, HANG_S)
        publisher.publish(cloud(XYZI))
        data = subscriber.wait_for_sample(HANG_S).data
    assert data.tobytes() == cloud(XYZI)["data"].tobytes()
    with pytest.raises(sft.Error, match="closed"):
        subscriber.take()


CLOUDS = {
    "organised": dict(channels=XYZI, height=16, width=64),
    "unordered": dict(channels=[("z", 8, 7, 1), ("x", 0, 7, 1), ("y", 4, 7, 1)], height=16, width=64),
    "padded": dict(channels=XYZI, height=16, width=64, step=48),
    "odd offsets": dict(channels=[("x", 1, 7, 1), ("y", 7, 8, 1), ("t", 17, 6, 1)], height=16, width=64, step=23),
    "rows with slack": dict(channels=XYZI, height=16, width=64, slack=13),
    "big-endian": dict(channels=XYZI, height=16, width=64, big=True),
    "several elements": dict(channels=[("x", 0, 7, 1), ("rgb", 4, 2, 3), ("n", 8, 3, 2)], height=16, width=64),
    "one name twice": dict(channels=[("x", 4, 7, 1), ("x", 0, 7, 1), ("y", 8, 5, 1)], height=16, width=64),
    "one row": dict(channels=XYZI, height=1, width=1024),
    "no columns": dict(channels=XYZI, height=16, width=0),
    "no rows": dict(channels=XYZI, height=0, width=64),
}


@pytest.mark.parametrize("name", CLOUDS)
def test_every_layout_of_clouds_is_read_as_plain_numpy_does(pair, name):
    given = cloud(**CLOUDS[name])
    height, width, step, order = given["height"], given["width"], given["point_step"], "><"[not given["is_bigendian"]]
    sample = pair.send(given)
    points = sample.points()
    shape = (height, width) if height != 1 else (width,)
    assert points.shape == shape
    for channel in {field["name"]: field for field in reversed(given["fields"])}.values():
        dtype = np.dtype(order + FORMATS[channel["datatype"]])
        rows = [given["data"][row * given["row_step"]:][:width * step].reshape(width, step) for row in range(height)]
        size = dtype.itemsize * channel["count"]
        plain = [np.ascontiguousarray(row[:, channel["offset"]:channel["offset"] + size]).view(dtype) for row in rows]
        expected = np.array(plain, dtype).reshape(*shape, *[channel["count"]] * (channel["count"] > 1))
        for found in (points[channel["name"]], sample.columns(channel["name"])[0]):
            assert found.shape == expected.shape
            np.testing.assert_array_equal(found, expected)
            assert not found.flags.writeable
    if points.size and not given["row_step"] - width * step:
        again = sample.copy()
        again.data = np.frombuffer(points.tobytes(), np.uint8) if points.dtype.itemsize == step else given["data"]
        came = pair.send(again, topic="again")
        assert came.point_step == step and came.points().tobytes() == points.tobytes()


def test_windows_and_parts_are_strides_over_the_whole_cloud(pair):
    given = cloud(XYZI, height=8, width=20)
    whole = pair.send(given).points("x", "z")
    part = pair.send(given, "width, height, data{x,z}[1:20:3]", topic="part", as_remote=True).points("x", "z")
    assert part.shape == (8, 7)
    for channel in "xz":
        np.testing.assert_array_equal(part[channel], whole[channel][:, 1::3])


def test_a_channel_that_is_missing_is_named(pair):
    sample = pair.send(cloud(XYZI))
    with pytest.raises(sft.Error, match="no channel 'ring'; it has x, y, z, intensity"):
        sample.points("x", "ring")
    with pytest.raises(sft.Error, match="not a cloud"):
        sample.header.points("x")


@pytest.mark.parametrize("encoding, dtype, channels", [("rgb8", "u1", 3), ("mono16", "<u2", 1), ("32FC1", "<f4", 1),
                                                       ("bgra8", "u1", 4), ("64FC2", "<f8", 2)])
def test_images_are_height_by_width_by_channels(pair, encoding, dtype, channels):
    height, width, slack = 5, 7, 3
    row = width * channels * np.dtype(dtype).itemsize
    data = np.random.default_rng(2).integers(0, 256, (height, row + slack), np.uint8)
    expected = np.ascontiguousarray(data[:, :row]).view(dtype).reshape(height, width, channels)
    given = dict(height=height, width=width, encoding=encoding, step=row + slack, data=data)
    pixels = pair.send(given, type="sensor_msgs/Image").image()
    assert pixels.shape == ((height, width, channels) if channels > 1 else (height, width))
    np.testing.assert_array_equal(pixels.reshape(expected.shape), expected)
    assert not pixels.flags.writeable
    window = "data[rows 1:4, columns 2:7:2]"
    part = pair.send(given, window, type="sensor_msgs/Image", topic="window", as_remote=True).image()
    np.testing.assert_array_equal(part, pixels[1:4, 2:7:2])


def test_the_cells_of_a_map_have_rows_and_columns(pair):
    data = np.arange(12, dtype=np.int8)
    given = dict(info=dict(width=4, height=3), data=data)
    sample = pair.send(given, type="nav_msgs/OccupancyGrid")
    np.testing.assert_array_equal(sample.cells("data"), data.reshape(3, 4))


def test_a_field_has_precedence_over_a_method_of_its_name(pair):
    given = {"points": [{"x": 1}, {"x": 2}]}
    sample = pair.send(given, type="geometry_msgs/Polygon")
    assert [point.x for point in sample.points] == [1, 2]


def test_selections_and_conditions_are_texts_as_everywhere(pair):
    publisher, subscriber = pair.open("width @ width > 5")
    for width in (3, 8):
        publisher.publish(width=width)
    assert subscriber.wait_for_sample(HANG_S).width == 8
    subscriber.set_selection("height")
    assert eventually(lambda: subscriber.requested == "height")


def test_a_scalar_of_a_large_cloud_is_read_in_microseconds(pair):
    sample = pair.send(dict(cloud(XYZI), data=np.zeros(6_291_456, np.uint8)))
    before = time.perf_counter()
    for _ in range(1000):
        sample.width
    assert (time.perf_counter() - before) / 1000 < 50e-6
