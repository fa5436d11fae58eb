"""Services: each call ends with its response or with the reason, and is carried out once."""

import asyncio
import threading

import pytest

import sft
from conftest import HANG_S, eventually

SET_BOOL = "std_srvs/SetBool"


def switched(request):
    return dict(success=True, message="on" if request.data else "off")


def test_a_call_ends_with_its_response(pair):
    with pair.nodes[0].client("lights", SET_BOOL) as lights, pair.nodes[1].service("lights", SET_BOOL, switched):
        assert lights.call(data=True, timeout=HANG_S).message == "on"
        assert lights.call({"data": False}, timeout=HANG_S).message == "off"
        response = lights.call(lights.type.request(data=True), timeout=HANG_S)
        assert (response.success, response.message) == (True, "on")
        assert lights.is_available()


def test_the_types_are_those_of_the_file():
    found = sft.find_service(SET_BOOL)
    assert found == sft.find_service("std_srvs/srv/SetBool")
    assert found.name == "std_srvs/srv/SetBool"
    parts = (found.request, found.response, found.call, found.reply)
    assert [part.name.removeprefix(found.name) for part in parts] == ["_Request", "_Response", "_Call", "_Reply"]
    with pytest.raises(sft.Error, match="there is no std_srvs/srv/SetBull.srv below"):
        sft.find_service("std_srvs/SetBull")


def test_a_client_without_a_type_takes_that_of_the_server(pair):
    with pair.nodes[1].service("lights", SET_BOOL, switched), pair.nodes[0].client("lights") as lights:
        assert lights.type == sft.find_service(SET_BOOL)
        assert lights.call(data=True, timeout=HANG_S).message == "on"


def test_what_the_handler_raises_reaches_the_client(pair, capfd):
    def handler(request):
        if request.data:
            raise sft.Error("no such lamp")
        return dict(success=True, message=7)

    with pair.nodes[0].client("lights", SET_BOOL) as lights, pair.nodes[1].service("lights", SET_BOOL, handler):
        with pytest.raises(sft.Error, match="^service 'lights': the server refuses: no such lamp$"):
            lights.call(data=True, timeout=HANG_S)
        assert "Traceback" not in capfd.readouterr().err, "a refusal is no fault of the server"
        with pytest.raises(sft.Error, match="the server refuses: 'response.message' is 7; a text was expected"):
            lights.call(data=False, timeout=HANG_S)
        assert "Traceback" in capfd.readouterr().err


def test_a_response_that_cannot_be_sent_ends_the_call_with_the_reason(pair):
    with pair.nodes[1].service("lights", SET_BOOL, lambda _: dict(message="x" * 2000), max_sample_bytes=1000), \
            pair.nodes[0].client("lights", SET_BOOL) as lights:
        with pytest.raises(sft.Error, match="service 'lights': the server refuses: .*1000"):
            lights.call(data=True, timeout=HANG_S)


def test_a_server_that_departs_ends_the_call(pair):
    entered, may_end = threading.Event(), threading.Event()

    def handler(_):
        entered.set()
        may_end.wait(HANG_S)

    server, lights = pair.nodes[1].service("lights", SET_BOOL, handler), pair.nodes[0].client("lights", SET_BOOL)
    closing = threading.Thread(target=lambda: (entered.wait(HANG_S), may_end.set(), server.close()))
    closing.start()
    server._publisher.publish_cdr = lambda _: True  # the reply is lost, and the server ends meanwhile
    with pytest.raises(sft.Error, match="service 'lights': its server, on node 'b', has gone"):
        lights.call(data=True, timeout=HANG_S)
    closing.join()


def test_a_request_that_does_not_fit_is_refused_at_the_client(pair):
    with pair.nodes[0].client("lights", SET_BOOL) as lights, pair.nodes[1].service("lights", SET_BOOL, switched):
        with pytest.raises(TypeError, match="'request.data' is 'yes'"):
            lights.call(data="yes", timeout=HANG_S)
        assert lights.call(data=True, timeout=HANG_S).message == "on", "the client can be used again"


def test_without_a_server_the_call_ends_after_its_timeout(node):
    with node.client("lights", SET_BOOL) as lights, pytest.raises(sft.Error, match="no server"):
        lights.call(data=True, timeout=0.2)
    assert not lights._calling.locked()


def test_two_threads_cannot_call_with_one_client(pair):
    entered, may_end = threading.Event(), threading.Event()

    def handler(_):
        entered.set()
        assert may_end.wait(HANG_S)

    with pair.nodes[0].client("lights", SET_BOOL) as lights, pair.nodes[1].service("lights", SET_BOOL, handler):
        calling = threading.Thread(target=lights.call, args=({"data": True},), kwargs={"timeout": HANG_S})
        calling.start()
        assert entered.wait(HANG_S)
        with pytest.raises(sft.Error, match="give each thread and task a client"):
            lights.call(data=True)
        may_end.set()
        calling.join()


def test_a_repeated_call_is_carried_out_once_and_answered_again(pair):
    seen, replies = [], []

    def handler(request):
        seen.append(request.data)

    found = sft.find_service(SET_BOOL)
    with pair.nodes[1].service("lights", SET_BOOL, handler), \
            pair.nodes[0].publisher("lights/call", found.call, reliable=True) as calls, \
            pair.nodes[0].subscriber("lights/reply", found.reply, "*", replies.append, reliable=True) as subscriber:
        assert calls.wait_for_subscribers(1, HANG_S)
        assert eventually(lambda: any(writer["connected"] for writer in subscriber.status()["writers"]))
        call = dict(client=5, number=1, timeout_ms=60_000, request=dict(data=True))

        def is_answered(times):
            calls.publish(call)
            return len(replies) >= times

        assert eventually(lambda: is_answered(2))
        assert seen == [True]
        assert {(reply.client, reply.number, reply.error) for reply in replies} == {(5, 1, "")}
        calls.publish(dict(call, number=2, server=1))
        calls.publish(dict(call, number=3))
        assert eventually(lambda: seen == [True, True]), "a call to another server is not carried out"


def in_loop(main):
    """Runs a coroutine, which hangs if it takes longer than HANG_S."""
    return asyncio.run(asyncio.wait_for(main(), HANG_S))


def test_coroutines_call_and_serve_in_one_event_loop(pair):
    async def handler(request):
        await asyncio.sleep(0)
        if request.data:
            return switched(request)
        raise sft.Error("no such lamp")

    async def main():
        with pair.nodes[1].service("lights", SET_BOOL, handler), \
                pair.nodes[0].client("lights", SET_BOOL) as one, pair.nodes[0].client("lights", SET_BOOL) as other:
            response, refused = await asyncio.gather(one.call_async(data=True), other.call_async({"data": False}),
                                                     return_exceptions=True)
            assert response.message == "on"
            assert str(refused) == "service 'lights': the server refuses: no such lamp"

    in_loop(main)


def test_the_response_of_a_cancelled_call_belongs_to_no_later_call(pair):
    async def main():
        entered, may_end = asyncio.Event(), asyncio.Event()

        async def handler(request):
            entered.set()
            await may_end.wait()
            return switched(request)

        with pair.nodes[1].service("lights", SET_BOOL, handler), pair.nodes[0].client("lights", SET_BOOL) as lights:
            cancelled = asyncio.create_task(lights.call_async(data=True))
            await entered.wait()
            with pytest.raises(sft.Error, match="give each thread and task a client"):
                await lights.call_async(data=True)
            cancelled.cancel()
            with pytest.raises(asyncio.CancelledError):
                await cancelled
            may_end.set()
            assert (await lights.call_async(data=False)).message == "off"

    in_loop(main)


def test_closing_a_service_cancels_its_coroutine_and_ends_the_call(pair, capfd):
    async def main():
        entered, ended = asyncio.Event(), asyncio.Event()

        async def handler(_):
            entered.set()
            try:
                await asyncio.Event().wait()
            finally:
                ended.set()

        service = pair.nodes[1].service("lights", SET_BOOL, handler)
        with pair.nodes[0].client("lights", SET_BOOL) as lights:
            calling = asyncio.create_task(lights.call_async(data=True))
            await entered.wait()
            service.close()
            await ended.wait()
            with pytest.raises(sft.Error, match="service 'lights': its server, on node 'b', has gone"):
                await calling

    in_loop(main)
    assert "Traceback" not in capfd.readouterr().err


def test_a_coroutine_that_calls_ends_with_the_time_the_node_or_the_client(node):
    async def main():
        lights = node.client("lights", SET_BOOL)
        with pytest.raises(sft.Error, match="no server"):
            await lights.call_async(data=True, timeout=0.2)
        calling = asyncio.create_task(lights.call_async(data=True))
        while not lights._subscriber._readers:
            await asyncio.sleep(0)
        lights.close()
        with pytest.raises(sft.Error, match="closed"):
            await calling
        others = node.client("others", SET_BOOL)
        node.interrupt()
        with pytest.raises(sft.Error, match="interrupted"):
            await others.call_async(data=True)

    in_loop(main)
