"""Nodes, publishers, loans and subscribers."""

import asyncio
import atexit
import collections
import concurrent.futures
import contextlib
import contextvars
import inspect
import itertools
import json
import os
import sys
import threading
import time
import traceback
import weakref

from sft import _sft
from sft._errors import Error

Event = collections.namedtuple("Event", "kind node text count")
Event.__doc__ = "One event of an endpoint. `kind` is 'matched', 'samples_lost' and so on; `text` is for people."

_DAEMON = os.path.join(os.path.dirname(__file__), "sftd")  # a wheel brings it along

_open_nodes = weakref.WeakSet()
_calling = contextvars.ContextVar("calling", default=None)  # the subscriber whose coroutine runs


def _end():
    """Closes everything that is open before the interpreter ends, so that no thread is in the library any more."""
    _Background.join_s = 2  # a callback that never returns does not keep the interpreter from ending
    try:
        for node in list(_open_nodes):
            try:
                node.close()
            except Exception:
                traceback.print_exc()
    finally:
        _sft.end()


def _forget():
    """Makes a forked process forget the nodes and threads of its parent, which it must not use."""
    _sft.forget_threads(len(_open_nodes) > 0)
    _open_nodes.clear()


atexit.register(_end)
os.register_at_fork(after_in_child=_forget)


def _show_failure(of):
    """Shows the exception of a callback. Later calls are not affected."""
    print(f"sft: exception in the callback of {of}:", file=sys.stderr)
    traceback.print_exc()


class _Background:
    """A thread that calls `step` until it returns False or is stopped. It does not keep the interpreter alive."""

    join_s = None

    def __init__(self, name, step):
        self.stops = False
        self._step = step
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def _run(self):
        while not self.stops and self._step() is not False:
            pass

    def stop(self, joins=True):
        self.stops = True
        if joins and self._thread is not threading.current_thread():
            self._thread.join(self.join_s)


class Node:
    """Joins the domain. The node is closed at the end of a `with` block, by close(), or with the interpreter.

    Arguments: name, namespace, remap, domain, transport ('automatic', 'shm', 'udp'), peers, interfaces,
    multicast_discovery, use_sim_time, daemon_path, daemon_idle_exit [s]; log(level, text), and log_level: 'debug',
    'info', 'warning' or 'error'. NodeOptions in sft/options.h says what they mean.
    """

    def __init__(self, name="node", *, log=None, log_level=None, **options):
        if os.path.exists(_DAEMON) and "SFT_DAEMON" not in os.environ:
            options.setdefault("daemon_path", _DAEMON)
        level = log_level or ("info" if log else None)
        self._node = _sft.Node({"name": name, **options}, level if log else None)
        self._name = name
        self._log = log
        self._callbacks = {}  # for events, by their numbers
        self._numbers = itertools.count(1)
        self._endpoints = weakref.WeakSet()
        self._called_back = set()  # subscribers with a callback live until they or the node are closed
        self._callback_thread = _Background("sft-callbacks", self._call_queued) if log else None
        _open_nodes.add(self)

    def __repr__(self):
        return f"<sft.Node {self._name}>"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Ends all waits, callbacks, publishers and subscribers of the node."""
        if self not in _open_nodes:  # it is closed, or belongs to the process from which this one was forked
            return
        _open_nodes.discard(self)
        self._node.interrupt()
        try:
            for endpoint in list(self._endpoints):
                endpoint.close()
        finally:
            if self._callback_thread:
                self._callback_thread.stop()
            self._callback_thread = None
            self._node.close()

    def interrupt(self):
        """Ends all present and later waits in this node."""
        self._node.interrupt()

    @property
    def is_interrupted(self):
        return self._node.is_interrupted()

    def find_type(self, topic, timeout=5.0):
        """Waits until a node has announced the topic, and returns its type."""
        return _sft.Type(self._node.find_type(topic, timeout))

    def topics(self):
        """Returns the known topics as dicts with topic, type, publishers and subscribers (names of nodes)."""
        return self._node.topics()

    def snapshot(self):
        """Returns the state and the counts of the node, its publishers and its subscribers (sft/snapshot.h)."""
        return json.loads(self._node.snapshot())

    def now(self):
        """Returns the time in ns since 1970, or the simulated time with use_sim_time."""
        return self._node.now_ns()

    def publisher(self, topic, type=None, *, on_event=None, **options):
        """Opens a publisher. `type` is an sft.Type or its name. None: the type that other nodes have announced.

        Options: reliable, transient_local, history_depth, deadline [s], lifespan [s], max_blocking [s],
        manual_liveliness, liveliness_lease [s], max_sample_bytes, max_bytes_per_s, resend_bytes,
        asynchronous, transport.
        """
        with self._callback(on_event) as to:
            opened = self._node.publisher(topic, self._type(topic, type)._whole, options, to)
            return Publisher(self, opened, topic, to)

    def subscriber(self, topic, type=None, fields=None, callback=None, *, on_event=None, **options):
        """Opens a subscriber.

        `fields` names what is needed: "height, data{x,y,z}[::2] @ at most 10 Hz", or "*" for all. Without `fields`, SFT
        records the fields that the program reads, and soon sends the subscriber only these. `callback(sample)` is
        called by a thread of the subscriber; it may be a coroutine function if an event loop of asyncio runs now.

        Options: reliable, transient_local, depth, depth_bytes, max_rate_hz, max_held, deadline [s],
        manual_liveliness, liveliness_lease [s], further_selections, transport, pollable (True by default without a
        callback; False makes wait() quicker, and leaves out fileno() and `async for`), learn_samples,
        narrow_after_samples, as_remote.
        """
        options.setdefault("pollable", callback is None)
        with self._callback(on_event) as to:
            opened = self._node.subscriber(topic, self._type(topic, type)._whole, fields, options, to)
            return Subscriber(self, opened, topic, to, callback)

    def service(self, name, type, handler, **options):
        """Opens the server of a service: handler(request) returns the response, as a message or a mapping.

        `type` is the name of a type, "std_srvs/SetBool", or that of sft.find_service(). The handler runs on a thread of
        the service, for one request at a time. It may be a coroutine function if an event loop of asyncio runs now. Its
        exceptions are sent to the client. Exceptions other than sft.Error are also printed here. Options are those of
        the publisher of replies.
        """
        from sft._service import Service
        return Service(self, name, self._service_type(name, type), handler, options)

    def client(self, name, type=None, **options):
        """Opens a client of a service. The server may start later. If `type` is None, the type that a server announces
        is used. Options are those of the publisher of calls."""
        from sft._service import Client
        return Client(self, name, self._service_type(name, type), options)

    def _service_type(self, name, type):
        from sft import ServiceType, find_service
        if type is None:
            return ServiceType(*(self.find_type(f"{name}/{part}") for part in ("call", "reply")))
        return find_service(type) if isinstance(type, str) else type

    def _type(self, topic, type):
        if type is None:
            return self.find_type(topic)
        if isinstance(type, str):
            from sft import find_type
            return find_type(type)
        return type

    @contextlib.contextmanager
    def _callback(self, function):
        """Yields the number of a callback for events. Removes the callback if the endpoint cannot be opened."""
        if function is None:
            yield 0
            return
        number = next(self._numbers)  # never one of before: calls for that one may still be in the queue
        self._callbacks[number] = function
        if not self._callback_thread:
            self._callback_thread = _Background("sft-callbacks", self._call_queued)
        try:
            yield number
        except BaseException:
            self._callbacks.pop(number, None)
            raise

    def _call_queued(self):
        for to, kind, node, text, count in self._node.queued_calls(0.1):
            callback = self._callbacks.get(to)
            try:
                if to == 0:
                    self._log(kind, text)
                elif callback:
                    callback(Event(kind, node, text, count))
            except BaseException:  # SystemExit, too, would end the thread without a word
                _show_failure("the log" if to == 0 else "events")


class _Endpoint:
    """The common base of publishers and subscribers. They keep their node open."""

    def __init__(self, node, opened, topic, events_to):
        self._node = node
        self._opened = opened
        self.topic = topic
        node._endpoints.add(self)
        self._forget_callback = weakref.finalize(self, node._callbacks.pop, events_to, None)  # also without close()
        self._forget_callback.atexit = False

    def __repr__(self):
        return f"<sft.{type(self).__name__} of '{self.topic}'>"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    @property
    def type(self):
        """The message type."""
        return _sft.Type(self._opened.type())

    def close(self):
        """Closes the endpoint. Samples and arrays stay valid."""
        self._node._endpoints.discard(self)
        self._opened.close()
        self._forget_callback()


class Publisher(_Endpoint):
    """Publishes messages on a topic. Any thread may publish."""

    def __init__(self, node, opened, topic, events_to):
        super().__init__(node, opened, topic, events_to)
        self.loan = opened.loan  # one call less for each loan

    def publish(self, message=None, /, **fields):
        """publish(message) or publish(width=3, header={"frame_id": "lidar"}). Fields that are not given are zero or
        empty; a stamp may be "now", and a header "auto". A message is an sft.Message, a mapping, a sample, or an
        object with the fields as attributes.

        Returns False if a reader misses the sample because it does not keep up.
        """
        return self._opened.publish(fields if message is None else message)

    def publish_cdr(self, payload):
        """Publishes an encoded message: 4 bytes of encapsulation and the body, as in bags."""
        return self._opened.publish_cdr(memoryview(payload).cast("B"))

    def loan(self, *, for_overwrite=False, **fields):
        """Returns a message that is filled in its memory: with publisher.loan(height=480, data=921600) as image.

        A number in place of a sequence of numbers is its number of elements. The elements are zero, or with
        `for_overwrite` whatever the memory contained: write them all. The end of the `with` block publishes it; an
        exception gives it back. Other lists and texts are as given.
        """

    def wait_for_subscribers(self, count=1, timeout=None):
        """Waits until this many subscribers are served. Returns False when the time [s] is over, or after
        interrupt()."""
        return self._opened.wait_for_subscribers(count, timeout)

    def assert_liveliness(self):
        """Asserts that the publisher is alive. Needed if manual_liveliness is set."""
        self._opened.assert_liveliness()

    def status(self):
        """Returns the counts, and each reader (sft/status.h)."""
        return self._opened.status()


class Subscriber(_Endpoint):
    """Receives samples of a topic: by take(), `for`, `async for`, or a callback. Any thread may take.

    A sample stays in shared memory as long as the program holds it or an array over it. A subscriber may hold max_held
    samples of a publisher (256). Further samples are not received until some are released. sample.copy() holds nothing.
    """

    def __init__(self, node, opened, topic, events_to, callback):
        super().__init__(node, opened, topic, events_to)
        self.take = opened.take  # one call less for each sample
        self._callback = callback
        self._thread = None
        self._cancels = True  # whether close() ends a coroutine that runs
        self._readers = set()  # futures of event loops that wait for samples
        if callback is None:
            return
        self._loop = asyncio.get_running_loop() if inspect.iscoroutinefunction(callback) else None
        self._ready = threading.Event()  # the thread begins once this object is complete
        node._called_back.add(self)
        self._thread = _Background(f"sft-{topic}"[:15], self._call_back)
        self._ready.set()

    def take(self):
        """Returns the oldest sample that was not taken yet, or None."""

    def take_latest(self):
        """Returns the newest sample, or None. Older samples are skipped."""
        return self._opened.take_latest()

    def wait(self, timeout=None):
        """Waits until there is a sample to take. Returns False when the time [s] is over, or after interrupt()."""
        return self._opened.wait(timeout)

    def wait_for_sample(self, timeout=None):
        """Waits for a sample and takes it. Returns None when the time [s] is over, when the subscriber is closed, or
        after interrupt()."""
        end = None if timeout is None else time.monotonic() + timeout
        left = timeout
        try:
            sample = self.take()
            while sample is None and self.wait(left):
                sample = self.take()
                if end is not None:
                    left = end - time.monotonic()
                    if left <= 0:
                        break
            return sample
        except Error:
            if not self._opened.is_over():
                raise
            return None

    def fileno(self):
        """Returns a file descriptor that is readable while there is a sample to take. Wait on it, but do not read from
        it."""
        fd = self._opened.file_descriptor()
        if fd < 0:
            raise ValueError(f"{self!r} has no file descriptor: open it with pollable=True and without a callback")
        return fd

    def set_selection(self, fields, which=0):
        """Requests other fields, parts or conditions."""
        self._opened.set_selection(fields, which)

    def set_max_rate_hz(self, max_rate_hz, which=0):
        """Changes the maximum rate; 0: all samples."""
        self._opened.set_max_rate_hz(max_rate_hz, which)

    @property
    def requested(self):
        """The selection that is requested at present, as text for `fields`."""
        return self._opened.requested()

    @property
    def held(self):
        """The number of samples that the program holds at present."""
        return self._opened.held()

    def status(self, which=0):
        """Returns the counts, and each publisher (sft/status.h)."""
        return self._opened.status(which)

    def close(self):
        """Closes the subscriber. After that, no callback runs, unless close() was called in the callback. Samples and
        arrays stay valid."""
        self._node._called_back.discard(self)
        if self._thread:
            within = _calling.get() is self  # a coroutine is neither waited for nor cancelled by itself
            self._cancels = not within
            self._thread.stop(joins=not within)
        super().close()
        for readable in list(self._readers):
            with contextlib.suppress(RuntimeError):  # the loop is closed
                readable.get_loop().call_soon_threadsafe(lambda r=readable: r.done() or r.set_result(None))

    def __iter__(self):
        """Yields samples until the subscriber is closed or its node is interrupted."""
        while not self._opened.is_over():
            sample = self.wait_for_sample()
            if sample is not None:
                yield sample
            del sample  # the program keeps the sample alive if it needs it

    async def __aiter__(self):
        """Yields samples in an event loop of asyncio, until the subscriber is closed or its node is interrupted."""
        loop = asyncio.get_running_loop()
        try:
            fd = os.dup(self.fileno())  # several loops may wait
        except Error:
            if self._opened.is_over():
                return
            raise
        try:
            while not self._opened.is_over():
                sample = self.wait_for_sample(0)
                if sample is not None:
                    yield sample
                    del sample  # the program keeps the sample alive if it needs it
                else:
                    await self._readable(loop, fd)
        finally:
            os.close(fd)

    async def _readable(self, loop, fd, timeout=None):
        """Waits until the file descriptor is readable, the subscriber is closed, or the time [s] is over."""
        readable = loop.create_future()

        def end():
            readable.done() or readable.set_result(None)

        self._readers.add(readable)
        if self._opened.is_over():  # another thread may have closed it before `readable` was added
            end()
        loop.add_reader(fd, end)
        timer = None if timeout is None else loop.call_later(timeout, end)
        try:
            await readable
        finally:
            loop.remove_reader(fd)
            if timer:
                timer.cancel()
            self._readers.discard(readable)

    def _call_back(self):
        self._ready.wait()
        if self._opened.is_over():
            return False
        sample = self.wait_for_sample(0.1)
        if sample is None:
            return True
        try:
            result = self._callback(sample)
            del sample  # the program keeps the sample alive if it needs it
            if self._loop is not None:
                self._finish(asyncio.run_coroutine_threadsafe(self._run(result), self._loop))
        except BaseException:  # SystemExit, too, would end the thread without a word
            _show_failure(repr(self))
        return True

    async def _run(self, coroutine):
        _calling.set(self)
        await coroutine

    def _finish(self, running):
        """Waits for a coroutine. Cancels it if the subscriber is closed meanwhile by other code."""
        while not running.done():
            concurrent.futures.wait([running], 0.1)
            if self._loop.is_closed():
                return
            if self._thread.stops and self._cancels:
                running.cancel()
                return
        running.result()
