"""Usage: ros_idl.py OUTPUT_DIR FILE...

Converts each FILE, .../<package>/msg/<Type>.msg, to OUTPUT_DIR/<package>/msg/<Type>.idl with ROS 2's own tool, and
.../srv/<Type>.srv likewise.
"""
import pathlib
import sys

from rosidl_adapter.msg import convert_msg_to_idl
from rosidl_adapter.srv import convert_srv_to_idl

output, *files = map(pathlib.Path, sys.argv[1:])
for file in files:
    package = file.parent.parent
    folder = file.parent.name
    convert = convert_srv_to_idl if folder == "srv" else convert_msg_to_idl
    convert(package, package.name, file.relative_to(package), output / package.name / folder)
