#!/usr/bin/env python3
"""Writes how ROS 2's own rosidl_adapter reads .msg files.

rosidl.py OUTPUT_DIR FILE...    FILE: <root>/<package>/msg/<Name>.msg

writes below OUTPUT_DIR
  <package>/msg/<Name>.idl   as rosidl_adapter converts the file, but with include guards and without the defaults of
                             arrays and sequences, which it writes in a way of its own
  types.inc                  calls of describe.cpp, one per type and one per constant
  values.json                {type: {"constants": {name: value}, "initial": {field: value}}}
"""
import json
import pathlib
import sys

from rosidl_adapter.parser import parse_message_file
from rosidl_adapter.resource import evaluate_template


def idl_text(package, name, message):
    for field in message.fields:
        if field.type.is_array:
            field.default_value = None
    data = {'pkg_name': package, 'relative_input_file': f'msg/{name}.msg', 'msg': message}
    guard = f'{package}_{name}_ORACLE'
    text = evaluate_template('msg.idl.em', data).replace('>>', '> >')  # idlc would read `>>` as a shift
    return f'#ifndef {guard}\n#define {guard}\n{text}\n#endif\n'


def values(message):
    return {'constants': {c.name: c.value for c in message.constants},
            'initial': {f.name: f.default_value for f in message.fields if f.default_value is not None}}


def calls(package, name, message):
    type_name = f'{package}::msg::{name}'
    lines = [f'describe<{type_name}>(types);']
    lines += [f'constant<{type_name}>(types, "{c.name}", {type_name}::{c.name});' for c in message.constants]
    return lines


def main():
    output = pathlib.Path(sys.argv[1])
    all_values, all_calls, includes = {}, [], []
    for file in map(pathlib.Path, sys.argv[2:]):
        package, name = file.parts[-3], file.stem
        message = parse_message_file(package, file)
        all_values[f'{package}::msg::{name}'] = values(message)
        all_calls += calls(package, name, message)
        includes.append(f'#include <{package}/msg/{name}.hpp>')
        idl = output / package / 'msg' / f'{name}.idl'
        idl.parent.mkdir(parents=True, exist_ok=True)
        # Encoded as rosidl_adapter does; the bytes are UTF-8.
        idl.write_text(idl_text(package, name, message), encoding='iso-8859-1')
    body = '\n  '.join(all_calls)
    (output / 'types.inc').write_text('\n'.join(includes) + f'\n#define SFT_DESCRIBE_ALL(types) \\\n  ' +
                                      body.replace('\n', ' \\\n') + '\n')
    (output / 'values.json').write_text(json.dumps(all_values, indent=1))


main()
