"""SFT in Python: publish and subscribe to the messages of ROS 2, of any type, without generated code.

    import sft

    node = sft.Node("monitor")
    cloud = node.subscriber("points").wait_for_sample()  # soon sent only what the program reads
    print(cloud.header.frame_id, cloud.width)
    xyz = cloud.points("x", "y", "z")                    # a numpy array over the sample's memory

docs/python.md has the rest.
"""

import os as _os

try:
    from sft import _sft
except ImportError as _error:
    import glob as _glob
    import importlib.machinery as _machinery
    import sys as _sys
    _built = [_os.path.basename(_file) for _file in _glob.glob(_os.path.join(_os.path.dirname(__file__), "_sft.*"))]
    if any(_name == f"_sft{_suffix}" for _name in _built for _suffix in _machinery.EXTENSION_SUFFIXES):
        raise  # The package was built for this Python, and the error names what the package needs.
    raise ImportError(f"{_error}; this is {_sys.implementation.cache_tag} ({_sys.executable}), and the package was "
                      f"built as {_built or 'nothing'}: use that Python, or build the package with this one") from None
import numpy as _numpy
if not _sft.knows_numpy_2 and int(_numpy.__version__.partition(".")[0]) >= 2:
    raise ImportError(f"this sft was built with a pybind11 before 2.12, which works with numpy 1 only, and this is "
                      f"numpy {_numpy.__version__}: install 'numpy<2', or build sft with a later pybind11")
from sft._absent import Absent
from sft._errors import AbsentError, Error
from sft._message import Message, cells, copy, image
from sft._node import Event, Loan, Node, Publisher, Subscriber
from sft._service import Client, Service, ServiceType
from sft._sft import Sample, SampleInfo, Type, View

__version__ = _sft.version
__all__ = ["Absent", "AbsentError", "Client", "Error", "Event", "Loan", "Message", "Node", "Publisher", "Sample",
           "SampleInfo", "Service", "ServiceType", "Subscriber", "Type", "View", "cells", "columns", "copy",
           "find_service", "find_type", "image", "info", "points", "type_from_file", "type_from_msg"]

# Fields have precedence over methods of the same name. These functions work with all types.
points = View.points
columns = View.columns
info = Sample.info.fget


def _roots(directories):
    """Returns the directories with packages of messages: those given, those of an installed ROS 2, and SFT's own."""
    here = _os.path.dirname(__file__)
    ros = [_os.path.join(prefix, "share") for prefix in _os.environ.get("AMENT_PREFIX_PATH", "").split(":") if prefix]
    prefix = _os.path.normpath(_os.path.join(here, *[".."] * 4))  # of PREFIX/lib/python3/dist-packages/sft
    own = [_os.path.join(here, "interfaces"), _os.path.join(prefix, "share", "sft", "interfaces")]
    return [*map(_os.fspath, directories), *ros, *own]


def find_type(name, directories=()):
    """Returns an installed type: find_type("sensor_msgs/PointCloud2"). Looks in these directories of packages first,
    then in those of AMENT_PREFIX_PATH, and then among the messages of SFT."""
    return Type(_sft.find_msg(name, _roots(directories)))


def find_service(name, directories=()):
    """Returns an installed type of services: find_service("std_srvs/SetBool"). Looks where find_type() looks."""
    package, _, last = name.replace("/srv/", "/").rpartition("/")
    return ServiceType(*(find_type(f"{package}/srv/{last}_{part}", directories) for part in ("Call", "Reply")))


def type_from_msg(name, text):
    """Returns the type that .msg text defines. Nested messages follow after lines of '=', as in bags."""
    return Type(_sft.from_msg(name, text))


def type_from_file(file, directories=()):
    """Returns the type of a file ROOT/my_msgs/msg/Status.msg. Nested messages are searched for below ROOT first."""
    return Type(_sft.from_msg_file(_os.fspath(file), _roots(directories)))
