#!/usr/bin/env python3
"""Reads an MCAP file by its specification, and the messages by the definitions in the file.

read_mcap.py FILE    prints a JSON object for each message, in the order of the file: topic, type, times, value.

It shares nothing with the reader and the writer of SFT: it is what other programs make of the files. It reads the file
twice, from its begin and by the index at its end, and fails if the two differ or a checksum is wrong.
"""

import ctypes
import json
import re
import struct
import sys
import zlib

MAGIC = b"\x89MCAP0\r\n"
FORMATS = {"bool": "?", "byte": "B", "char": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i",
           "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d"}


class Fields:
    """The fields of a record, one after the other."""

    def __init__(self, content):
        self.content, self.at = content, 0

    def number(self, code):
        value, = struct.unpack_from("<" + code, self.content, self.at)
        self.at += struct.calcsize("<" + code)
        return value

    def raw(self, length):
        assert self.at + length <= len(self.content), "a field is longer than its record"
        self.at += length
        return self.content[self.at - length:self.at]

    def text(self):
        return self.raw(self.number("I")).decode()

    def map(self, key, value):
        inner, found = Fields(self.raw(self.number("I"))), {}
        while inner.at < len(inner.content):
            name = key(inner)
            found[name] = value(inner)
        return found


def records(content):
    at = 0
    while at < len(content):
        opcode, length = struct.unpack_from("<BQ", content, at)
        assert at + 9 + length <= len(content), f"a record at {at} is too long"
        yield opcode, at, content[at + 9:at + 9 + length]
        at += 9 + length


def unpacked(compression, data, size):
    if compression == "":
        return data
    out = ctypes.create_string_buffer(size)
    if compression == "zstd":
        library = ctypes.CDLL("libzstd.so.1")
        library.ZSTD_decompress.restype = ctypes.c_size_t
        got = library.ZSTD_decompress(out, ctypes.c_size_t(size), data, ctypes.c_size_t(len(data)))
    else:
        assert compression == "lz4", compression
        library = ctypes.CDLL("liblz4.so.1")
        context = ctypes.c_void_p()
        library.LZ4F_createDecompressionContext(ctypes.byref(context), 100)
        library.LZ4F_decompress.restype = ctypes.c_size_t
        written, read = ctypes.c_size_t(size), ctypes.c_size_t(len(data))
        left = library.LZ4F_decompress(context, out, ctypes.byref(written), data, ctypes.byref(read), None)
        assert left == 0 and read.value == len(data)
        got = written.value
    assert got == size, "the compressed size is wrong"
    return out.raw


class File:
    def __init__(self, content):
        assert content.startswith(MAGIC) and content.endswith(MAGIC), "the magic bytes are missing"
        self.content = content
        self.schemas, self.channels, self.metadata = {}, {}, {}

    def messages_from_begin(self):
        found, indexes = [], {}
        for opcode, at, content in records(self.content[8:-8]):
            if opcode == 1:
                assert Fields(content).text() == "ros2"
            elif opcode == 6:
                found += self.chunk(content)
            elif opcode == 12:
                fields = Fields(content)
                name = fields.text()
                self.metadata[name] = fields.map(Fields.text, Fields.text)
            elif opcode == 15:
                crc = Fields(content).number("I")
                assert crc in (0, zlib.crc32(self.content[:8 + at])), "the checksum of the data is wrong"
                return found
            else:
                assert opcode in (7, 9), opcode
        raise AssertionError("there is no end of the data")

    def messages_by_index(self):
        footer = Fields(self.content[-28:-8])
        start, offsets, crc = footer.number("Q"), footer.number("Q"), footer.number("I")
        assert crc == zlib.crc32(self.content[start:-12]), "the checksum of the summary is wrong"
        found, statistics = [], None
        for opcode, _, content in records(self.content[start:offsets]):
            fields = Fields(content)
            if opcode == 8:
                fields.raw(16)
                offset, length = fields.number("Q"), fields.number("Q")
                places = fields.map(lambda f: f.number("H"), lambda f: f.number("Q"))
                (_, _, chunk), = records(self.content[offset:offset + length])
                data = self.chunk_records(chunk)
                by_index = []
                for channel, place in places.items():
                    index_length, = struct.unpack_from("<Q", self.content, place + 1)
                    assert self.content[place] == 7
                    index = Fields(self.content[place + 9:place + 9 + index_length])
                    assert index.number("H") == channel
                    entries = Fields(index.raw(index.number("I")))
                    while entries.at < len(entries.content):
                        time, at = entries.number("Q"), entries.number("Q")
                        message_length, = struct.unpack_from("<Q", data, at + 1)
                        message = self.message(data[at + 9:at + 9 + message_length])
                        assert data[at] == 5 and message[0] == channel and message[2] == time
                        by_index.append((at, message))
                found += [message for _, message in sorted(by_index, key=lambda one: one[0])]
            elif opcode == 11:
                statistics = fields.number("Q")
        assert statistics == len(found), "the statistics are wrong"
        return found

    def chunk_records(self, content):
        fields = Fields(content)
        fields.raw(16)
        size, crc, compression = fields.number("Q"), fields.number("I"), fields.text()
        data = unpacked(compression, fields.raw(fields.number("Q")), size)
        assert crc == zlib.crc32(data), "the checksum of a chunk is wrong"
        return data

    def chunk(self, content):
        found = []
        for opcode, _, inner in records(self.chunk_records(content)):
            fields = Fields(inner)
            if opcode == 3:
                number = fields.number("H")
                self.schemas[number] = (fields.text(), fields.text(), fields.text())
            elif opcode == 4:
                number = fields.number("H")
                self.channels[number] = (fields.number("H"), fields.text(), fields.text(),
                                         fields.map(Fields.text, Fields.text))
            else:
                assert opcode == 5
                message = self.message(inner)
                assert message[0] in self.channels, "a message is in front of its channel"
                assert self.channels[message[0]][0] in self.schemas, "and of its schema"
                found.append(message)
        return found

    @staticmethod
    def message(content):
        return struct.unpack_from("<HIQQ", content) + (content[22:],)


class Definition:
    """What a text in `ros2msg` defines."""

    def __init__(self, name, text):
        self.types = {}
        self.root = re.sub("/msg/", "/", name)
        current = self.root
        self.types[current] = []
        for line in text.split("\n"):
            line = line.split("#")[0].strip()
            if line.startswith("==="):
                continue
            if line.startswith("MSG: "):
                current = line[5:]
                self.types[current] = []
            elif line and "=" not in re.sub("<=", "", line):
                self.types[current].append(line.split()[:2])


class Cdr:
    def __init__(self, data):
        assert data[:2] == b"\0\1", "no little-endian CDR"
        self.body, self.at = data[4:], 0

    def scalar(self, code):
        size = struct.calcsize(code)
        self.at += -self.at % size
        value, = struct.unpack_from("<" + code, self.body, self.at)
        self.at += size
        return value

    def value(self, kind, definition):
        bracket = re.match(r"(.*)\[(<=)?(\d*)\]$", kind)
        if bracket:
            bounded = bracket[2] or not bracket[3]
            count = self.scalar("I") if bounded else int(bracket[3])
            return [self.value(bracket[1], definition) for _ in range(count)]
        if kind.startswith("string"):
            length = self.scalar("I")
            self.at += length
            return self.body[self.at - length:self.at - 1].decode()
        if kind in FORMATS:
            return self.scalar(FORMATS[kind])
        return {name: self.value(inner, definition) for inner, name in definition.types[kind]}


def main(path):
    with open(path, "rb") as file:
        parsed = File(file.read())
    messages = parsed.messages_from_begin()
    assert messages == parsed.messages_by_index(), "the index names other messages"
    for channel, sequence, log_time, publish_time, data in messages:
        schema, topic, encoding, metadata = parsed.channels[channel]
        name, schema_encoding, text = parsed.schemas[schema]
        assert (encoding, schema_encoding) == ("cdr", "ros2msg")
        definition, cdr = Definition(name, text), Cdr(data)
        value = cdr.value(definition.root, definition)
        assert len(cdr.body) - cdr.at <= 3, "the definition does not cover the message"
        print(json.dumps({"topic": topic, "type": name, "sequence": sequence, "log_time": log_time,
                          "publish_time": publish_time, "value": value, "qos": metadata["offered_qos_profiles"]}))


main(sys.argv[1])
