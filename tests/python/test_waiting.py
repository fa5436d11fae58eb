"""Waits, loops, callbacks, threads, signals, fork and the end of the interpreter.

Threads that open and close, and ends of the interpreter, are tried SFT_TEST_TIMES times as often; ./run soak sets it.
"""

import asyncio
import os
import resource
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import sft
from conftest import HANG_S, eventually

CLOCK = "builtin_interfaces/Time"
TIMES = int(os.environ.get("SFT_TEST_TIMES", "1"))


def run(program, timeout=120):
    return subprocess.run([sys.executable, "-c", program], timeout=timeout, capture_output=True, text=True)


def test_a_wait_returns_when_the_time_is_over_or_the_node_is_interrupted(node):
    subscriber = node.subscriber("t", CLOCK)
    assert not subscriber.wait(0) and not subscriber.wait(0.05) and subscriber.wait_for_sample(0.01) is None
    threading.Timer(0.1, node.interrupt).start()
    assert not subscriber.wait() and list(subscriber) == []


def test_an_interrupt_ends_a_wait_for_subscribers(node):
    publisher = node.publisher("t", CLOCK)
    threading.Timer(0.1, node.interrupt).start()
    assert not publisher.wait_for_subscribers()


def test_a_wait_for_a_sample_that_others_take_ends_in_time(node):
    publisher, subscriber = node.publisher("t", CLOCK), node.subscriber("t", CLOCK)
    assert publisher.wait_for_subscribers(1, HANG_S)
    publisher.publish(sec=1)
    assert subscriber.wait(HANG_S)
    subscriber.take = lambda: None  # as if another thread were always quicker
    before = time.monotonic()
    assert subscriber.wait_for_sample(0.2) is None and time.monotonic() - before < HANG_S


@pytest.mark.parametrize("finds", [lambda take: take(), lambda take: None])
def test_loops_end_if_another_thread_closes_the_subscriber_at_any_step(node, finds):
    def closes_before_it_takes(subscriber):
        take = subscriber.take

        def closed():
            subscriber.close()
            return finds(take)

        subscriber.take = closed
        return subscriber

    async def read(subscriber):
        return [sample async for sample in subscriber]

    assert list(closes_before_it_takes(node.subscriber("t", CLOCK))) == []
    assert closes_before_it_takes(node.subscriber("t", CLOCK)).wait_for_sample() is None
    reading = read(closes_before_it_takes(node.subscriber("t", CLOCK)))
    assert asyncio.run(asyncio.wait_for(reading, HANG_S)) == []


async def has_reader(subscriber):
    """Returns once an event loop waits for samples of the subscriber."""
    while not subscriber._readers:
        await asyncio.sleep(0)


def test_a_closed_event_loop_does_not_keep_a_node_from_closing(node):
    async def read(subscriber):
        async for _ in subscriber:
            pass

    loop, others, subscriber = asyncio.new_event_loop(), [], node.subscriber("t", CLOCK)
    reading = loop.create_task(read(subscriber))
    loop.run_until_complete(asyncio.wait_for(has_reader(subscriber), HANG_S))
    others.append(node.publisher("t", CLOCK))
    loop.close()
    node.close()
    with pytest.raises(sft.Error, match="closed"):
        others[0].publish(sec=1)
    reading._log_destroy_pending = False  # asyncio would say that nobody has cancelled it


def test_closing_ends_a_wait_of_another_thread(node):
    subscriber = node.subscriber("t", CLOCK)
    threading.Timer(0.1, subscriber.close).start()
    assert not subscriber.wait()


@pytest.mark.parametrize("wait", ["node.subscriber('t', 'builtin_interfaces/Time').wait()", "node.find_type('t', 60)",
                                  "node.publisher('t', 'builtin_interfaces/Time').wait_for_subscribers(1)",
                                  "next(iter(node.subscriber('t', 'builtin_interfaces/Time')))"])
def test_ctrl_c_ends_a_wait(wait):
    child = subprocess.Popen([sys.executable, "-c", f"""
import sft
node = sft.Node("child", transport="udp")
try:
    print("ready", flush=True)
    {wait}
except KeyboardInterrupt:
    print("interrupted")
"""], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    assert eventually(lambda: Path(f"/proc/{child.pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "S")
    child.send_signal(signal.SIGINT)
    before = time.monotonic()
    out, _ = child.communicate(timeout=HANG_S)
    assert out == "interrupted\n" and child.returncode == 0 and time.monotonic() - before < 5


def test_ctrl_c_ends_a_program_that_publishes():
    child = subprocess.Popen([sys.executable, "-c", """
import sft
node = sft.Node("child", transport="udp")
publisher = node.publisher("t", "sensor_msgs/Image")
try:
    print("ready", flush=True)
    while True:
        publisher.publish(data=bytes(1_000_000))
except KeyboardInterrupt:
    publisher.publish(width=1)
    print("interrupted")
"""], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    child.send_signal(signal.SIGINT)
    out, _ = child.communicate(timeout=60)
    assert out == "interrupted\n" and child.returncode == 0


def test_other_threads_run_while_one_waits(node):
    subscriber = node.subscriber("t", CLOCK)
    waiting = threading.Thread(target=subscriber.wait, args=(0.5,))
    waiting.start()
    steps = 0
    while waiting.is_alive():
        steps += 1
    assert steps > 1000


def test_async_for_gets_all_samples_and_idles_without_processor_time(pair):
    publisher, subscriber = pair.open(type=CLOCK, depth=64)

    async def read():
        got = []
        async for sample in subscriber:
            got.append(sample.sec)
            if len(got) == 20:
                return got

    async def main():
        reading = asyncio.create_task(read())
        await asyncio.wait_for(has_reader(subscriber), HANG_S)
        before, before_s = resource.getrusage(resource.RUSAGE_SELF), time.thread_time()
        assert not (await asyncio.wait({reading}, timeout=2))[0], "there is no sample yet"
        after, after_s = resource.getrusage(resource.RUSAGE_SELF), time.thread_time()
        assert after_s - before_s < 0.01, "the thread of the loop sleeps"
        idle_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        for i in range(20):
            publisher.publish(sec=i)
        return idle_s, await asyncio.wait_for(reading, HANG_S)

    idle_s, got = asyncio.run(main())
    assert got == list(range(20)) and idle_s < 0.1  # both nodes and the test itself


def test_async_loops_end_when_they_are_cancelled_or_the_subscriber_closes(node):
    async def read(subscriber):
        async for _ in subscriber:
            pass

    async def main():
        subscriber = node.subscriber("t", CLOCK)
        cancelled = asyncio.create_task(read(subscriber))
        await asyncio.wait_for(has_reader(subscriber), HANG_S)
        cancelled.cancel()
        with pytest.raises(asyncio.CancelledError):
            await cancelled
        closed = asyncio.create_task(read(subscriber))
        await asyncio.wait_for(has_reader(subscriber), HANG_S)
        subscriber.close()
        await asyncio.wait_for(closed, HANG_S)

    files = len(os.listdir("/proc/self/fd"))
    for _ in range(3):
        asyncio.run(main())
    assert len(os.listdir("/proc/self/fd")) <= files + 8


def test_a_callback_that_raises_is_shown_and_the_next_sample_follows(pair, capfd):
    got = []

    def callback(sample):
        got.append(sample.sec)
        if sample.sec % 10 == 0:
            raise RuntimeError("tenth")

    publisher, subscriber = pair.open(type=CLOCK, callback=callback, depth=128)
    for i in range(100):
        publisher.publish(sec=i)
    assert eventually(lambda: len(got) == 100)
    subscriber.close()
    assert got == list(range(100))
    assert capfd.readouterr().err.count("RuntimeError: tenth") == 10


def test_a_callback_may_be_a_coroutine(pair):
    async def main():
        got = asyncio.Queue()

        async def callback(sample):
            await asyncio.sleep(0)
            await got.put(sample.sec)

        publisher, subscriber = pair.open(type=CLOCK, callback=callback)
        publisher.publish(sec=5)
        assert await asyncio.wait_for(got.get(), HANG_S) == 5
        await asyncio.get_running_loop().run_in_executor(None, subscriber.close)

    asyncio.run(main())


def test_a_coroutine_may_close_its_subscriber_and_goes_on(pair):
    async def main():
        done = asyncio.Event()

        async def callback(_):
            subscriber.close()
            await asyncio.sleep(0.3)  # long enough to be cancelled
            done.set()

        publisher, subscriber = pair.open(type=CLOCK, callback=callback)
        publisher.publish(sec=5)
        await asyncio.wait_for(done.wait(), HANG_S)

    asyncio.run(main())


def test_a_callback_that_ends_its_thread_is_shown_and_the_next_sample_follows(pair, capfd):
    got = []

    def callback(sample):
        got.append(sample.sec)
        sys.exit("from the callback")

    publisher, subscriber = pair.open(type=CLOCK, callback=callback)
    publisher.publish(sec=1)
    publisher.publish(sec=2)
    assert eventually(lambda: len(got) == 2)
    subscriber.close()
    assert capfd.readouterr().err.count("SystemExit: from the callback") == 2


def test_a_callback_may_close_its_subscriber(pair):
    closed = threading.Event()

    def callback(_):
        subscriber.close()
        closed.set()

    publisher, subscriber = pair.open(type=CLOCK, callback=callback)
    publisher.publish(sec=1)
    assert closed.wait(HANG_S)


def test_events_and_lines_of_the_log_reach_python(node):
    events, lines = [], []
    with sft.Node("other", transport="udp", log=lambda level, text: lines.append((level, text))) as other:
        subscriber = other.subscriber("t", CLOCK, on_event=events.append)
        publisher = node.publisher("t", CLOCK)
        assert publisher.wait_for_subscribers(1, HANG_S)
        assert eventually(lambda: any(event.kind == "matched" and event.node == "node" for event in events))
        assert eventually(lambda: any(level == "info" and "matched" in text for level, text in lines))
        subscriber.close()


def test_a_callback_for_events_is_forgotten_with_its_endpoint(node):
    def on_event(_):
        pass

    closed = node.subscriber("t", CLOCK, on_event=on_event)
    dropped = node.publisher("t", CLOCK, on_event=on_event)
    assert len(node._callbacks) == 2
    closed.close()
    del dropped
    with pytest.raises(sft.Error):
        node.subscriber("t", CLOCK, "no_field", on_event=on_event)
    assert node._callbacks == {}


def test_threads_open_take_and_close_with_a_log_of_python():
    failures, end = [], time.monotonic() + 5 * TIMES

    def work(number):
        try:
            while time.monotonic() < end:
                with sft.Node(f"n{number}", transport="udp", log=lambda *_: None, log_level="debug") as node:
                    publisher = node.publisher("t", CLOCK)
                    subscriber = node.subscriber("t", CLOCK, callback=lambda sample: sample.sec)
                    publisher.publish(sec=1)
                    subscriber.close()
        except BaseException as error:
            failures.append(error)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60 + 5 * TIMES)
    assert not failures and not any(thread.is_alive() for thread in threads)


def test_a_forked_child_is_told_to_spawn_and_the_parent_goes_on(pair):
    publisher, subscriber = pair.open(type=CLOCK)
    child = os.fork()
    if child == 0:
        try:
            sft.Node("child")
            os._exit(1)
        except sft.Error as error:
            os._exit(7 if "spawn" in str(error) else 2)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
    publisher.publish(sec=9)
    assert subscriber.wait_for_sample(HANG_S).sec == 9


def test_a_forked_child_that_uses_what_its_parent_opened_is_told_to_spawn(node):
    publisher, subscriber = node.publisher("t", CLOCK), node.subscriber("t", CLOCK)
    loan = publisher.loan()

    async def read():
        async for _ in subscriber:
            pass

    uses = [subscriber.wait, subscriber.wait_for_sample, lambda: list(subscriber), lambda: asyncio.run(read()),
            lambda: publisher.publish(sec=1), loan.publish, publisher.wait_for_subscribers, node.topics,
            lambda: node.find_type("u")]
    child = os.fork()
    if child == 0:
        signal.alarm(HANG_S)
        refused = 0
        for use in uses:
            try:
                use()
            except sft.Error as error:
                refused += "spawn" in str(error)
        os._exit(refused)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == len(uses)


def test_a_forked_child_of_a_process_without_nodes_opens_its_own():
    done = run("""
import os, sft
child = os.fork()
if child == 0:
    with sft.Node("child", transport="udp") as node:
        publisher = node.publisher("t", "builtin_interfaces/Time")
        subscriber = node.subscriber("t", "builtin_interfaces/Time")
        assert publisher.wait_for_subscribers(1, 60)
        publisher.publish(sec=5)
        os._exit(subscriber.wait_for_sample(60).sec)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
""")
    assert done.stdout == "5\n", done.stderr


EXIT = """
import sys, threading, sft
node = sft.Node("exit", transport="udp")
subscriber = node.subscriber("t", "builtin_interfaces/Time", callback=lambda sample: got.append(sample))
got = []
publisher = node.publisher("t", "builtin_interfaces/Time")
publisher.wait_for_subscribers(1, 60)
waiting = node.subscriber("u", "builtin_interfaces/Time")
threading.Thread(target=waiting.wait, daemon=True).start()
def publish():
    while True:
        publisher.publish(sec=1)
threading.Thread(target=publish, daemon=True).start()
"""


@pytest.mark.parametrize("last", ["", "del node", "del subscriber, publisher", "node.close()", "sys.exit(0)",
                                  "loan = publisher.loan()", "raise SystemExit"])
def test_the_interpreter_ends_in_any_order(last):
    for _ in range(2 * TIMES):
        done = run(EXIT + last)
        # The thread that publishes may be told that its publisher is closed.
        assert done.returncode == 0 and "terminate" not in done.stderr, done.stderr


def test_a_callback_that_never_returns_does_not_keep_the_interpreter_from_ending():
    done = run("""
import sft, threading
called = threading.Event()
def callback(sample):
    called.set()
    threading.Event().wait()
node = sft.Node("exit", transport="udp")
subscriber = node.subscriber("t", "builtin_interfaces/Time", callback=callback)
publisher = node.publisher("t", "builtin_interfaces/Time")
publisher.wait_for_subscribers(1, 60)
publisher.publish(sec=1)
print(called.wait(60))
""")
    assert done.returncode == 0 and done.stdout == "True\n", done.stderr


def test_another_process_publishes_and_its_type_is_found(pair):
    child = subprocess.Popen([sys.executable, "-c", f"""
import sft
with sft.Node("child", transport="{pair.transport}", daemon_idle_exit=5) as node:
    publisher = node.publisher("images", "sensor_msgs/Image")
    print(publisher.wait_for_subscribers(1, 60), flush=True)
    with publisher.loan(height=2, width=3, step=3, encoding="mono8", data=6) as loan:
        loan.data[:] = range(6)
    input()
"""], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    subscriber = pair.nodes[1].subscriber("images", pair.nodes[1].find_type("images", HANG_S))
    sample = subscriber.wait_for_sample(HANG_S)
    assert sample.info.transport == pair.transport and sample.image().tolist() == [[0, 1, 2], [3, 4, 5]]
    child.communicate("\n", timeout=HANG_S)
    assert child.returncode == 0 and sample.data[5] == 5
