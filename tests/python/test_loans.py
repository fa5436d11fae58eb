"""Loans in Python: messages that are filled in the memory of the sample."""

import warnings

import numpy as np
import pytest

import sft
from conftest import HANG_S


def test_a_loan_is_filled_in_place_and_published_at_the_end_of_the_block(pair):
    publisher, subscriber = pair.open(type="sensor_msgs/Image")
    pixels = np.random.default_rng(1).integers(0, 256, (480, 640, 3), np.uint8)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with publisher.loan(header="auto", height=480, width=640, encoding="rgb8", step=1920, data=921_600) as loan:
            assert not loan.data.any() and len(loan.data) == 921_600
            loan.data.reshape(480, 640, 3)[:] = pixels
            loan.is_bigendian = 0
            loan.header.stamp.nanosec = 5
            loan["header.stamp.sec"] = 3
            assert subscriber.take() is None
    sample = subscriber.wait_for_sample(HANG_S)
    np.testing.assert_array_equal(sample.image(), pixels)
    assert (sample.header.stamp.sec, sample.header.stamp.nanosec, sample.step) == (3, 5, 1920)
    with pytest.raises(sft.Error, match="loan is over"):
        loan.data


def test_what_an_array_can_still_write_is_no_sample(pair):
    publisher, subscriber = pair.open(type="sensor_msgs/Image")
    with pytest.warns(RuntimeWarning, match="a copy of the loan was published"):
        with publisher.loan(data=1000) as loan:
            data = loan.data
            part = data[10:20]
            data[:] = 7
            del data
    sample = subscriber.wait_for_sample(HANG_S)
    part[:] = 9
    assert (sample.data == 7).all() and (part == 9).all()


def test_an_exception_gives_the_loan_back(pair):
    publisher, subscriber = pair.open(type="sensor_msgs/Image")
    for _ in range(300):  # more than there are chunks
        with pytest.raises(ZeroDivisionError):
            with publisher.loan(data=100_000):
                1 / 0
    with publisher.loan(data=1) as loan:
        loan.data[0] = 1
    assert subscriber.wait_for_sample(HANG_S).info.sequence == 1


def test_a_loan_refuses_what_does_not_fit(pair):
    publisher, _ = pair.open(type="sensor_msgs/Image")
    with publisher.loan(data=10, for_overwrite=True) as loan:
        with pytest.raises(ValueError, match="'height' is -1; an integer from 0"):
            loan.height = -1
        with pytest.raises(AttributeError, match="'hieght'"):
            loan.hieght = 1
        with pytest.raises(TypeError, match="'header' is a struct"):
            loan.header = {}
        for other in (np.zeros(11, np.uint8), [5]):
            with pytest.raises(ValueError, match=f"'data' has 10 elements; {len(other)} were given"):
                loan.data = other
        loan.data = np.arange(10)
    with pytest.raises(sft.Error, match="max_sample_bytes|at most"):
        publisher.loan(data=100_000_000)
    with pytest.raises(TypeError, match="'data' is 5"):
        publisher.publish(data=5)


@pytest.mark.parametrize("end", ["discard", "publish"])
def test_a_value_that_ends_the_loan_while_it_is_converted_is_not_written(pair, end):
    class Ends:
        def __index__(self):
            getattr(loan, end)()
            return 7

        def __array__(self, *_, **__):
            return np.full(10, self.__index__(), np.uint8)

    publisher, subscriber = pair.open(type="sensor_msgs/Image")
    for field in ("width", "data"):
        loan = publisher.loan(width=3, data=np.full(10, 3, np.uint8))
        with pytest.raises(sft.Error, match="loan is over"):
            setattr(loan, field, Ends())
        if end == "publish":
            sample = subscriber.wait_for_sample(HANG_S)
            assert sample.width == 3 and (sample.data == 3).all()


def test_loans_have_dlpack_and_the_buffer_protocol(pair):
    publisher, subscriber = pair.open(type="sensor_msgs/LaserScan")
    with publisher.loan(ranges=4) as loan:
        assert np.from_dlpack(loan.ranges).ctypes.data == loan.ranges.ctypes.data
        memoryview(loan.ranges)[0] = memoryview(loan.ranges)[1] = 1.5
        np.asarray(memoryview(loan.ranges))[2] = 2.5
    assert list(subscriber.wait_for_sample(HANG_S).ranges) == [1.5, 1.5, 2.5, 0]
