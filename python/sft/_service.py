"""Services: a client sends a request, and the one server of that name answers it."""

import collections
import threading

from sft import _sft
from sft._errors import Error
from sft._message import copy
from sft._node import _show_failure

ServiceType = collections.namedtuple("ServiceType", "call reply")
ServiceType.__doc__ = "A type of services. `request` and `response` are its messages; calling them makes one."
ServiceType.name = property(lambda self: self.call.name.removesuffix("_Call"))
ServiceType.request = property(lambda self: self.call._members[-1][-1])
ServiceType.response = property(lambda self: self.reply._members[-1][-1])


def _end_of(service, error):
    return Error(f"service '{service}': {error}")


class _Ends:
    """The common base of both sides: a publisher and a subscriber."""

    def __repr__(self):
        return f"<sft.{type(self).__name__} of '{self.name}'>"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Closes this side of the service."""
        self._subscriber.close()
        self._publisher.close()


class Service(_Ends):
    """The server of a service, which serves until it or its node is closed. See Node.service()."""

    def __init__(self, node, name, type, handler, options):
        self.name = name
        self.type = type
        self._handler = handler
        self._served = _sft.ServedCalls()
        self._publisher = node.publisher(f"{name}/reply", type.reply, **options, reliable=True)
        self._id = self._publisher.status()["id"]
        self._subscriber = node.subscriber(f"{name}/call", type.call, "*", self._hear, reliable=True,
                                           transport=options.get("transport", "automatic"))

    def _hear(self, call):
        if call.server not in (0, self._id):
            return
        is_new = self._served.is_new(call.client, call.number)
        try:
            if is_new:
                self._served.answered(call.client, self._answer(call), call.timeout_ms)
            elif is_new is not None:
                self._publisher.publish_cdr(self._served.reply(call.client))
        except Error:
            if not self._publisher._opened.is_over():  # the node may close the publisher before the subscriber
                raise

    def _answer(self, call):
        """Runs the handler, sends the reply, and returns it encoded."""
        head = dict(client=call.client, number=call.number, server=self._id)
        try:
            response = self._handler(call.request)
            return self._send(dict(head, response={} if response is None else response))
        except BaseException as error:  # SystemExit, too: the client must not wait in vain
            if not isinstance(error, Error):
                _show_failure(repr(self))
            reason = f"the server refuses: {error}".encode(errors="replace").decode().replace("\0", " ")
            return self._send(dict(head, error=reason))

    def _send(self, reply):
        encoded = self.type.reply.to_cdr(reply)
        self._publisher.publish_cdr(encoded)
        return encoded


class Client(_Ends):
    """A client of a service. It must be used by only one thread at a time. See Node.client()."""

    def __init__(self, node, name, type, options):
        self.name = name
        self.type = type
        self._node = node
        self._id = _sft.new_client_id()
        self._number = 0
        self._calling = threading.Lock()
        self._subscriber = node.subscriber(f"{name}/reply", type.reply, f"* @ client == {self._id}", reliable=True,
                                           transport=options.get("transport", "automatic"))
        self._publisher = node.publisher(f"{name}/call", type.call, **options, reliable=True)

    def is_available(self):
        """Returns whether there is exactly one server, and it is connected for both calls and replies."""
        return _sft.has_only_server(self._publisher._opened, self._subscriber._opened)

    def call(self, request=None, /, *, timeout=10.0, **fields):
        """call(data=True) or call(request): waits for the server, sends the request, and returns the response, an
        sft.Message. The handler of the server runs only once.

        Raises an sft.Error that says why if there is no response within the timeout [s], if the server departs
        meanwhile, or if its handler refuses. After an error it is unknown whether the handler has run.
        """
        if not self._calling.acquire(blocking=False):
            raise _end_of(self.name, "two threads call with one client at the same time: give each thread a client")
        try:
            call = _sft.ClientCall(self.name, timeout)
            self._number += 1
            message = dict(client=self._id, number=self._number, timeout_ms=call.timeout_ms(),
                           request=fields if request is None else request)
            while True:
                for reply in iter(self._subscriber.take, None):
                    if (reply.client, reply.number) == (self._id, self._number):
                        return self._response(reply)
                server, wait = call.next(self._publisher._opened, self._subscriber._opened)
                if server:
                    self._publisher.publish(dict(message, server=server))
                elif not self._subscriber.wait(wait) and self._node.is_interrupted:
                    raise _end_of(self.name, "waiting for the response was interrupted")
        finally:
            self._calling.release()

    def _response(self, reply):
        if reply.error:
            raise _end_of(self.name, reply.error)
        return copy(reply.response)
