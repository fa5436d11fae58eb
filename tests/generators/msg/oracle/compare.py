#!/usr/bin/env python3
"""compare.py VALUES_JSON DESCRIBE_OF_MSG DESCRIBE_OF_IDL DESCRIBE_OF_OUR_IDL

Fails if the types made from .msg files differ from those made from rosidl's IDL, or if their constants and defaults
differ from the values that rosidl's parser read. Fails, too, if our own IDL, which has no defaults and units, gives
another structure or other constants.
"""
import json
import struct
import subprocess
import sys


def described_by(program):
    return json.loads(subprocess.run([program], check=True, capture_output=True).stdout)


def equal(read, ours):
    """Returns true if `ours`, which may be a float32, is the value that rosidl read."""
    if isinstance(read, list):
        return len(read) == len(ours) and all(map(equal, read, ours))
    if isinstance(read, float) and abs(read) < 3e38:
        return ours in (read, struct.unpack('f', struct.pack('f', read))[0])
    return read == ours


def differences(name, read, msg, idl, our_idl):
    for what in ('hash', 'paths', 'units', 'constants'):
        if msg[what] != idl[what]:
            yield f'{name}: {what}: {msg[what]} from .msg, {idl[what]} from IDL'
        if what != 'units' and msg[what] != our_idl[what]:
            yield f'{name}: {what}: {msg[what]} from .msg, {our_idl[what]} from our IDL'
    for field, value in msg['initial'].items():
        if not isinstance(value, list) and not isinstance(value, dict) and value != idl['initial'][field]:
            yield f'{name}.{field}: default {value} from .msg, {idl["initial"][field]} from IDL'
    for what in ('constants', 'initial'):
        for member, value in read[what].items():
            if not equal(value, msg[what][member]):
                yield f'{name}.{member}: rosidl reads {value}, we read {msg[what][member]}'


def main():
    read = json.load(open(sys.argv[1], encoding='utf-8'))
    described = [described_by(program) for program in sys.argv[2:]]
    found = [d for name in read for d in differences(name, read[name], *(types[name] for types in described))]
    print('\n'.join(found) or f'{len(read)} types are the same')
    sys.exit(bool(found) or not read)


main()
