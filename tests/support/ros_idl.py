"""Usage: ros_idl.py OUTPUT_DIR FILE...

Lets ROS 2's own tool make OUTPUT_DIR/<package>/msg/<Type>.idl of each FILE, which is .../<package>/msg/<Type>.msg.
"""
import pathlib
import sys

from rosidl_adapter.msg import convert_msg_to_idl

output, *files = map(pathlib.Path, sys.argv[1:])
for file in files:
    package = file.parent.parent
    convert_msg_to_idl(package, package.name, file.relative_to(package), output / package.name / "msg")
