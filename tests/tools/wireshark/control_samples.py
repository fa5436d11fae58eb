"""Makes control samples by hand, as bytes, and the RTPS datagrams that carry them."""
import struct

VERSION = 16
ANNOUNCED = {"sft_writer": "sft_control::Record", "sft_reader": "sft_control::Record",
             "sft_heartbeat": "sft_control::HeartbeatSample"}
ENTITIES = {"sft_writer": 0x202, "sft_reader": 0x302, "chatter": 0x402, "sft_heartbeat": 0x502}
PREFIX = bytes(range(1, 13))
PARTICIPANT = PREFIX + bytes([0, 0, 1, 0xC1])


def leb(number):
    out = b""
    while number >= 0x80:
        out += bytes([number & 0x7F | 0x80])
        number >>= 7
    return out + bytes([number])


def short_text(text):
    return leb(len(text.encode())) + text.encode()


class Body:
    """The bytes of a record's body. Numbers are little-endian, without padding between them."""

    def __init__(self):
        self.bytes = b""

    def put(self, form, *values):
        self.bytes += struct.pack("<" + form, *values)
        return self

    def raw(self, data):
        self.bytes += data
        return self

    def octets(self, data):
        return self.put("I", len(data)).raw(data)

    def text(self, text):
        return self.put("B", len(text.encode())).raw(text.encode())

    def ids(self, ids):
        return self.put(f"I{len(ids)}Q", len(ids), *ids)


def part(leaf, rows=None, columns=None, channels=(), rule=0):
    """Returns the part of a field as bytes. Ranges are triples of begin, end (0: open) and step (0: empty)."""
    out = bytes([(rows is not None) | 2 * (columns is not None) | 4 * bool(channels) | 8 * bool(rule)]) + leb(leaf)
    out += leb(rule) if rule else b""
    for number in (rows or ()) + (columns or ()):
        out += leb(number)
    if channels:
        out += leb(len(channels)) + b"".join(short_text(name) for name in channels)
    return out


NOTHING = b"\x01\x00"  # the number in a `changed` without a deadband


def real(number):
    return b"\x03" + struct.pack("<d", number)


def condition(kind, leaves=(), number=NOTHING, comparison=0, percent=False):
    return bytes([kind + 8 * comparison + 64 * percent]) + leb(len(leaves)) + b"".join(map(leb, leaves)) + number


def every(ordinal):
    return condition(4, number=b"\x01" + leb(ordinal))


def joined(word, *conditions):
    return bytes([("and", "or").index(word)]) + leb(len(conditions)) + b"".join(conditions)


def selection(leaves, parts=(), conditions=(), rate=0):
    """Returns a selection as bytes. In `conditions` each condition precedes those in it; an item may have several."""
    mask = sum(1 << leaf for leaf in leaves)
    mask = mask.to_bytes((mask.bit_length() + 7) // 8, "little")
    out = bytes([bool(parts) | 2 * bool(conditions) | 4 * bool(rate)]) + leb(len(mask)) + mask
    if parts:
        out += leb(len(parts)) + b"".join(parts)
    if conditions:
        out += leb(len(conditions)) + b"".join(conditions)
    return out + (leb(rate) if rate else b"")


class Wants:
    """The parts of a request besides the mask: a period, and a selection as bytes."""

    def __init__(self, period=0, selection_bytes=b""):
        self.period, self.selection_bytes = period, selection_bytes

    def __add__(self, other):
        return Wants(self.period or other.period, self.selection_bytes or other.selection_bytes)


WHOLE = Wants()


def want(selection_bytes):
    return Wants(selection_bytes=selection_bytes)


def period(us):
    return Wants(period=us)


def record(kind, body, slot=1, revision=1, version=VERSION):
    return PARTICIPANT + struct.pack("<IBBHQI", slot, kind, version, 0, revision, len(body)) + body


def key(kind=0, slot=1):
    return PARTICIPANT + struct.pack("<IB", slot, kind)


def request(reader=0x1122, leaves=(0,), wants=WHOLE, words=1, listening=(), **more):
    mask = sum(1 << leaf for leaf in leaves)
    body = Body().put("QQ", reader, 3).ids([mask >> 64 * i & (1 << 64) - 1 for i in range(words)])
    body.put("I", wants.period).octets(wants.selection_bytes).ids(listening).ids([]).ids([])
    return record(1, body.bytes, **more)


def endpoint(endpoint_id, role, description=b"", topic="scan", memory_failure="", given_topic="", **more):
    body = Body().put("QBQ", endpoint_id, role, 0x77)
    body.text("arm").text(topic).text(given_topic).text("pkg::msg::Scan").put("Q", 0x99).octets(description)
    body.raw(bytes(32)).text(memory_failure).put("Q", 5).raw(b"\1\1")
    body.put("I", 1).raw(bytes(10) + b"\xff\xff" + bytes([10, 0, 0, 1])).put("HIB", 7000, 4096, 0)
    body.put("QI", 0, 0).put("QB", 1 << 20, 0).raw(b"\1\0\0").put("QQQI", 0, 0, 0, 8)
    return record(0, body.bytes, **more)


def subscriber(reader=0x1122, description=b"", **more):
    return endpoint(reader, 1, description, **more)


def publisher(writer, description=b"", **more):
    return endpoint(writer, 0, description, **more)


def inquiry(topic, wants_accounts=False, **more):
    return record(2, Body().text(topic).put("?", wants_accounts).bytes, **more)


def heartbeat(process, version=VERSION):
    return b"SHB" + bytes([version]) + PARTICIPANT + struct.pack("<QQQ", process, 1, 2)


def member(name, kind=11, shape=0, struct_number=None, attributes=b""):
    out = bytes([kind | shape << 4 | bool(attributes) << 7]) + short_text(name) + (leb(3) if shape == 1 else b"")
    return (out if struct_number is None else out + leb(struct_number)) + attributes


def description(*structs, enumerations=()):
    """Returns a type description. A struct is a list of members; the last one is the type. Enumerations are names."""
    out = b"\x01" + leb(len(enumerations))
    for names in enumerations:
        out += short_text("pkg::msg::E") + b"\x00" + leb(len(names))
        out += b"".join(short_text(name) + leb(number) for number, name in enumerate(names))
    out += leb(len(structs))
    for number, members in enumerate(structs):
        out += short_text(f"pkg::msg::T{number}") + leb(len(members)) + b"".join(members)
    return out


def submessage(kind, flags, body):
    return struct.pack("<BBH", kind, flags, len(body)) + body


def data(payload, writer, reader=0, flags=0x05, encapsulation=b"\0\1\0\0"):
    head = struct.pack("<HH", 0, 16) + struct.pack(">II", reader, writer) + struct.pack("<iI", 0, 1)
    payload += bytes(-len(payload) % 4)
    return submessage(0x15, flags, head + encapsulation + payload)


def parameter(number, value):
    value += bytes(-len(value) % 4)
    return struct.pack("<HH", number, len(value)) + value


def rtps(*submessages):
    return b"RTPS\x02\x01\x01\x10" + PREFIX + b"".join(submessages)


HEARTBEAT = submessage(0x07, 0x01, struct.pack(">II", 0, 0x302) + struct.pack("<iIiII", 0, 1, 0, 1, 1))


def announcement(topic):
    """Returns Cyclone's announcement of a writer, from which Wireshark learns the topic and its type."""
    text = [struct.pack("<I", len(name) + 1) + name.encode() + b"\0"
            for name in (topic, ANNOUNCED.get(topic, "std::String"))]
    parameters = (parameter(0x05, text[0]) + parameter(0x07, text[1]) +
                  parameter(0x5A, PREFIX + struct.pack(">I", ENTITIES[topic])) + parameter(0x01, b""))
    return rtps(data(parameters, writer=0x3C2, reader=0x3C7, encapsulation=b"\0\3\0\0"))


def sample(topic, *payloads, **more):
    """Returns a datagram with these samples and, behind them, a heartbeat."""
    return rtps(*(data(payload, ENTITIES[topic], **more) for payload in payloads), HEARTBEAT)


def fragments(topic, payload, size):
    """Returns datagrams with a sample in fragments of `size` bytes. A heartbeat follows the last fragment."""
    data, out = b"\0\1\0\0" + payload, []
    for number, at in enumerate(range(0, len(data), size), 1):
        head = struct.pack("<HH", 0, 28) + struct.pack(">II", 0, ENTITIES[topic]) + struct.pack("<iI", 0, 1)
        one = head + struct.pack("<IHHI", number, 1, size, len(data)) + data[at:at + size]
        out.append(rtps(submessage(0x16, 0x01, one + bytes(-len(one) % 4)), HEARTBEAT))
    return out


def fnv(data, value=0xCBF29CE484222325):
    for byte in data:
        value = (value ^ byte) * 0x100000001B3 % (1 << 64)
    return value


def hash_of(data):
    return fnv(struct.pack("<Q", len(data)) + data)


def name_of(mask, parts=b"", conditions=b""):
    """Returns the number that stands for a request in datagrams."""
    if parts:
        mask = fnv(struct.pack("<QQ", mask, hash_of(parts)))
    return fnv(struct.pack("<QQ", mask, hash_of(conditions))) if conditions else mask
