"""Usage: ros_structs.py OUTPUT_DIR FILE...

Makes the C++ structs of ROS 2 and their introspection with ROS 2's own generators, as colcon does. Each FILE is
.../<package>/msg/<Type>.msg; its header is OUTPUT_DIR/include/<package>/<package>/msg/<type>.hpp. Writes also

  OUTPUT_DIR/every_struct.h     includes all structs, and SFT's messages in the namespace my::sft_msgs; the macro
                                EACH_ROS_STRUCT(USE) is USE(<package>, <Type>) for each
  OUTPUT_DIR/introspection.cpp  all sources of the introspection
"""
import collections
import functools
import json
import pathlib
import sys

import rosidl_generator_cpp
import rosidl_pycommon
import rosidl_typesupport_introspection_cpp
from rosidl_adapter.msg import convert_msg_to_idl

snake_case = rosidl_pycommon.convert_camel_case_to_lower_case_underscore


def generate(output, package, names):
    """Runs both generators for the messages of one package, whose IDL is in the output already."""
    arguments = output / 'arguments.json'
    for generator in rosidl_generator_cpp, rosidl_typesupport_introspection_cpp:
        arguments.write_text(json.dumps({
            'package_name': package,
            'output_dir': str(output / 'include' / package / package),
            'template_dir': f'/usr/share/{generator.__name__}/resource',
            'idl_tuples': [f'{output / "idl" / package}:msg/{name}.idl' for name in names],
            'target_dependencies': [],
        }))
        generator.generate_cpp(str(arguments))


def every_struct(messages, places):
    """Returns the text of every_struct.h. `places` are the beginnings of the names of the messages' headers."""
    lines = ['#pragma once', '#include <rosidl_typesupport_introspection_cpp/message_type_support_decl.hpp>']
    for (package, name), place in zip(messages, places):
        lines += [f'#include <{place}struct.hpp>', f'#include <my/sft_msgs/{package}/msg/{name}.hpp>']
    lines += ['namespace rosidl_typesupport_introspection_cpp {']  # declared before some of the sources use them
    lines += ['template <> const rosidl_message_type_support_t* '
              f'get_message_type_support_handle<{package}::msg::{name}>();' for package, name in messages]
    uses = ' '.join(f'USE({package}, {name})' for package, name in messages)
    return '\n'.join(lines + ['}', f'#define EACH_ROS_STRUCT(USE) {uses}\n'])


def main():
    rosidl_pycommon.parse_idl_file = functools.cache(rosidl_pycommon.parse_idl_file)  # both generators read the same
    output, *files = map(pathlib.Path, sys.argv[1:])
    packages = collections.defaultdict(list)
    for file in files:
        package = file.parent.parent
        convert_msg_to_idl(package, package.name, file.relative_to(package), output / 'idl' / package.name / 'msg')
        packages[package.name].append(file.stem)
    for package, names in packages.items():
        generate(output, package, names)
    messages = [(package, name) for package, names in packages.items() for name in names]
    places = [f'{package}/msg/detail/{snake_case(name)}__' for package, name in messages]
    (output / 'every_struct.h').write_text(every_struct(messages, places))
    sources = ''.join(f'#include <{place}type_support.cpp>\n' for place in places)
    (output / 'introspection.cpp').write_text('#include "every_struct.h"\n' + sources)


main()
