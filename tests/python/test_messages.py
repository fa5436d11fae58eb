"""Python values in messages. Values that fit arrive unchanged. Others are refused, and the error names their path."""

import ast
import copy
import pickle
import time

import numpy as np
import pytest

import sft
from conftest import HANG_S, cloud
from sft.stubs import stubs

EVERY = """
bool yes
uint8 small
int32 number
uint32 natural
int64 large
float32 single
float64 double
string text
string<=4 short
float64[3] triple
uint8[] bytes
float32[] floats
bool[] flags
int16[<=3] few
string[] names
test/Inner inner
test/Inner[] inners
test/Inner[2] two
================================================================================
MSG: test/Inner
int16 a
string b
"""


@pytest.fixture(scope="module")
def every():
    return sft.type_from_msg("test/Every", EVERY)


@pytest.mark.parametrize("field, value, expected", [
    ("yes", True, True), ("yes", np.bool_(True), True), ("small", np.int64(5), 5), ("small", True, 1),
    ("number", -2**31, -2**31), ("natural", 2**32 - 1, 2**32 - 1), ("large", np.uint8(3), 3), ("single", 1, 1.0),
    ("single", np.float64(1.5), 1.5), ("single", float("nan"), float("nan")), ("double", np.float32(1.5), 1.5),
    ("double", 2**60, 2.0**60), ("text", "mühle", "mühle"), ("triple", (1, 2, 3), [1, 2, 3]),
    ("triple", np.arange(3), [0, 1, 2]), ("bytes", b"abc", [97, 98, 99]), ("bytes", bytearray(b"a"), [97]),
    ("bytes", np.arange(10)[::2], [0, 2, 4, 6, 8]), ("bytes", memoryview(b"ab"), [97, 98]), ("bytes", [], []),
    ("bytes", np.arange(6, dtype="u1").reshape(2, 3), [0, 1, 2, 3, 4, 5]),
    ("floats", np.array([1.5, -2], ">f4"), [1.5, -2]), ("floats", [1, 2.5], [1, 2.5]), ("floats", [True], [1.0]),
    ("flags", [True, False], [True, False]), ("few", [1, -1], [1, -1]), ("names", ("a", "b"), ["a", "b"]),
])
def test_what_python_people_write_arrives(pair, every, field, value, expected):
    sample = pair.send({field: value}, type=every)
    arrived = getattr(sample, field)
    if isinstance(arrived, (np.ndarray, tuple)):
        assert list(arrived) == list(expected)
    else:
        assert arrived == expected or (arrived != arrived and expected != expected)
        assert type(arrived) is type(expected)


@pytest.mark.parametrize("message, error, text", [
    ({"small": 300}, ValueError, "'small' is 300; an integer from 0 to 255 was expected"),
    ({"natural": -1}, ValueError, "'natural' is -1; an integer from 0 to 4294967295"),
    ({"number": 1.5}, TypeError, "'number' is 1.5; an integer from -2147483648"),
    ({"number": np.float32(1)}, TypeError, r"'number' is (1\.0|np\.float32\(1\.0\));"),  # numpy 1 or 2
    ({"number": None}, TypeError, "'number' is None"),
    ({"large": 2**63}, ValueError, "'large' is 9223372036854775808"), ({"yes": 2}, TypeError, "'yes' is 2"),
    ({"single": 1e39}, ValueError, "'single' is 1e\\+39"), ({"single": "1"}, TypeError, "'single' is '1'"),
    ({"double": 10**400}, ValueError, "'double' is 1000"), ({"text": b"a"}, TypeError, "'text' is b'a'; a text"),
    ({"text": "a\0b"}, ValueError, "'text' is .*without NUL"), ({"short": "abcde"}, ValueError, "at most 4 bytes"),
    ({"triple": (1, 2)}, ValueError, "'triple' has 2 elements; 3 were expected"),
    ({"few": [1, 2, 3, 4]}, ValueError, "'few' has 4 elements; it may have 3"),
    ({"few": [1, 40000]}, ValueError, r"'few\[1\]' is 40000; an integer from -32768 to 32767"),
    ({"few": [1, -40000]}, ValueError, r"'few\[1\]' is -40000"),
    ({"bytes": [1, -1]}, ValueError, r"'bytes\[1\]' is -1"),
    ({"bytes": "abc"}, TypeError, "'bytes' is 'abc'"), ({"bytes": [1, 256]}, ValueError, r"'bytes\[1\]' is 256"),
    ({"bytes": [1.5]}, TypeError, "'bytes' has elements of float64"), ({"bytes": [None]}, TypeError, "'bytes'"),
    ({"bytes": 5}, TypeError, "'bytes' is 5"), ({"floats": [1e300]}, ValueError, r"'floats\[0\]' is 1e\+300"),
    ({"names": "ab"}, TypeError, "'names' is 'ab'; a list"), ({"names": ["a", 1]}, TypeError, r"'names\[1\]' is 1"),
    ({"inners": [{"a": 1}, {"a": 70000}]}, ValueError, r"'inners\[1\].a' is 70000"),
    ({"inner": 3}, TypeError, "'inner.a' is 3|'inner' is 3"), ({"numbre": 1}, TypeError, "did you mean 'number'"),
    ({"inner": {"c": 1}}, TypeError, "'inner': test/Inner has no field 'c'"),
    ({"two": [{"a": 1}]}, ValueError, "'two' has 1 elements; 2 were expected"),
])
def test_what_does_not_fit_is_refused_by_its_path_also_without_readers(node, every, message, error, text):
    with pytest.raises(error, match=text):
        node.publisher("refused", every).publish(message)
    if "inner" not in message and "numbre" not in message:
        (name, value), = message.items()
        with pytest.raises(error, match=text):
            setattr(every(), name, value)


def test_an_exception_of_the_program_is_not_replaced(node, every):
    class Broken:
        def __index__(self):
            raise ZeroDivisionError("of the program")

        __float__ = __index__

        @property
        def yes(self):
            raise ZeroDivisionError("of the program")

    publisher = node.publisher("t", every)
    for message in (Broken(), {"number": Broken()}, {"double": Broken()}):
        with pytest.raises(ZeroDivisionError, match="of the program"):
            publisher.publish(message)


def test_messages_objects_and_mappings_are_published_alike(pair, every):
    class Inner:
        a, b = 3, "three"

    message = every(number=4, inner=Inner, inners=[{"a": 1}, Inner()])
    message.two[1].b = "second"
    sample = pair.send(message, type=every)
    assert (sample.number, sample.inner.a, sample.inner.b) == (4, 3, "three")
    assert [i.a for i in sample.inners] == [1, 3]
    assert [i.b for i in sample.two] == ["", "second"]
    assert sample.double == 0 and sample.text == "" and list(sample.triple) == [0, 0, 0]


def test_a_received_sample_is_published_again(pair):
    sample = pair.send(cloud([("x", 0, 7, 1)]))
    again = pair.send(sample, topic="again")
    assert again == sample
    assert pair.send({"header": sample.header, "data": sample.data}, topic="parts").header == sample.header


def test_a_stamp_may_be_now_and_a_header_auto(pair):
    before = time.time()
    sample = pair.send({"header": "auto"})
    assert before - 1 < sample.header.stamp.sec < time.time() + 1
    message = sft.find_type("std_msgs/Header")(stamp="now")
    assert pair.send(message, type="std_msgs/Header", topic="now").stamp.sec > before - 1


def test_messages_are_equal_if_all_fields_are(every):
    one = every(bytes=[1, 2, 3], inners=[{"a": 1}])
    assert one == every(bytes=np.array([1, 2, 3]), inners=[{"a": 1}])
    assert one != every(bytes=[1, 2, 4], inners=[{"a": 1}])
    assert one != every(bytes=[1, 2, 3], inners=[{"a": 2}])
    assert one != 3
    with pytest.raises(TypeError):
        hash(one)


def test_messages_and_samples_are_copied_and_pickled(pair, every):
    message = every(bytes=[1, 2, 3], inner={"b": "x"}, names=["n"])
    sample = pair.send(message, type=every)
    for twin in (copy.deepcopy(message), pickle.loads(pickle.dumps(message)), sample.copy(), copy.copy(sample),
                 copy.deepcopy(sample), pickle.loads(pickle.dumps(sample))):
        assert isinstance(twin, sft.Message) and twin == message
    deep = copy.deepcopy(message)
    deep.inner.b = "y"
    deep.bytes[0] = 9
    assert message.inner.b == "x" and message.bytes[0] == 1
    assert pickle.loads(pickle.dumps(sample.inner)) == message.inner


def test_repr_is_for_people(pair):
    sample = pair.send(cloud([("x", 0, 7, 1)]))
    assert repr(sample).startswith("PointCloud2(header=Header(stamp=Time(sec=7, nanosec=0), frame_id='lidar'), ")
    assert "fields=[PointField(name='x', offset=0, datatype=7, count=1)]" in repr(sample)
    assert "data=<400 x uint8>" in repr(sample)
    assert "frame_id: lidar" in str(sample)
    assert repr(sft.find_type("geometry_msgs/Vector3")(x=1)) == "Vector3(x=1, y=0.0, z=0.0)"


def test_six_megabytes_are_published_in_one_copy_within_five_milliseconds(pair):
    publisher, subscriber = pair.open("data")
    data = np.zeros(6_291_456, np.uint8)
    times = []
    for _ in range(10):
        before = time.monotonic()
        publisher.publish(data=data)
        times.append(time.monotonic() - before)
        assert subscriber.wait_for_sample(HANG_S) is not None
    assert min(times) < 0.005


def test_types_come_from_text_files_installations_and_other_nodes(node, every, tmp_path):
    folder = tmp_path / "my_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Speed.msg").write_text("std_msgs/Header header\nfloat64 speed  # [m/s]\n")
    speed = sft.type_from_file(folder / "Speed.msg")
    assert speed == sft.find_type("my_msgs/msg/Speed", [tmp_path]) and speed.name == "my_msgs/Speed"
    assert "float64 speed" in str(speed) and "[m/s]" in str(speed)
    publisher = node.publisher("speed", speed)
    with sft.Node("other", transport="udp") as other:
        assert other.find_type("speed", HANG_S) == speed
        assert other.subscriber("speed").type == publisher.type
    with pytest.raises(sft.Error, match="Spede") as error:
        sft.find_type("my_msgs/Spede", [tmp_path])
    assert error.value.code == "unavailable"


def test_errors_have_the_texts_of_the_library(node):
    with pytest.raises(sft.Error, match="hieght"):
        node.subscriber("t", "sensor_msgs/PointCloud2", "hieght")
    with pytest.raises(TypeError, match="no argument 'relaible'"):
        node.subscriber("t", "sensor_msgs/PointCloud2", relaible=True)
    with pytest.raises(TypeError, match="depth cannot be 'many'"):
        node.subscriber("t", "sensor_msgs/PointCloud2", depth="many")
    for seconds in (float("nan"), float("inf"), 1e300):
        with pytest.raises(ValueError, match="deadline is"):
            node.publisher("t", "sensor_msgs/PointCloud2", deadline=seconds)
    with pytest.raises(ValueError, match="timeout is nan"):
        node.subscriber("t", "sensor_msgs/PointCloud2").wait(float("nan"))
    with pytest.raises(sft.Error, match="not a sensor_msgs"):
        publisher = node.publisher("t", "sensor_msgs/PointCloud2")
        subscriber = node.subscriber("t", "sensor_msgs/PointCloud2")
        assert publisher.wait_for_subscribers(1, HANG_S)
        publisher.publish_cdr(b"\0\1\0\0short")
    assert subscriber.take() is None
    with pytest.raises(AttributeError, match="did you mean 'width'"):
        sft.find_type("sensor_msgs/PointCloud2")().widht = 3


def test_stubs_declare_fields_with_their_shapes_and_units(every):
    other = sft.type_from_msg("other/Inner", "float64 speed  # [m/s]\nfloat32 lambda")
    text = stubs([every, other, every])
    ast.parse(text)
    lines = text.splitlines()
    assert [line for line in lines if line.startswith("class")] == [
        "class Every(sft.Sample):", "class Inner(sft.View):", "class other_Inner(sft.Sample):"]
    for line in ("yes: bool", "small: int", "single: float", "text: str", "triple: NDArray[np.float64]  # 3 elements",
                 "flags: NDArray[np.bool_]", "few: NDArray[np.int16]  # at most 3", "names: tuple[str, ...]",
                 "inner: Inner", "inners: tuple[Inner, ...]", "two: tuple[Inner, ...]  # 2 elements",
                 "speed: float  # [m/s]"):
        assert "    " + line in lines
    assert not any("lambda" in line for line in lines), "no class can declare a field of this name"
