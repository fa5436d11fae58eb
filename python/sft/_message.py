"""Messages that a program owns, and functions for samples and messages: text, copies, comparison."""

import numpy as np

from sft import _sft
from sft._absent import Absent
from sft._fit import refuse_unknown

_SHOWN = 8  # elements of arrays and lists in repr()


class Message:
    """A message of a type. Its fields are attributes. Fields that are not set are zero or empty.

    A value is checked when it is set. If it does not fit, a TypeError or ValueError names the field, the value, and
    what was expected. Fields with nested messages take mappings: message.header = {"frame_id": "lidar"}.
    """

    __slots__ = ("_type", "_values", "_members")
    __hash__ = None

    def __init__(self, _type, /, **values):
        object.__setattr__(self, "_type", _type)
        object.__setattr__(self, "_values", {})
        object.__setattr__(self, "_members", {member[0]: member for member in _type._members})
        for name, value in values.items():
            setattr(self, name, value)

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        if name not in self._values:
            self._values[name] = _default(self._member(name))
        return self._values[name]

    def __setattr__(self, name, value):
        _, kind, shape, *_, nested = self._member(name)
        if not isinstance(value, Absent):
            self._type._check(name, value)
        if kind == "struct" and not isinstance(value, (str, Absent)):
            value = _message_of(nested, value) if shape == "single" else [_message_of(nested, v) for v in value]
        self._values[name] = value

    def __dir__(self):
        return list(self._members)

    def _member(self, name):
        try:
            return self._members[name]
        except KeyError:
            pass
        try:
            refuse_unknown([name], list(self._members), self._type.name, "")
        except TypeError as error:
            raise AttributeError(str(error)) from None

    @property
    def _names(self):
        return list(self._members)

    @property
    def _type_name(self):
        return self._type.name

    def _is_absent(self, name):
        return isinstance(self._values.get(name), Absent)

    def __reduce__(self):
        return _restored, (self._type, dict(self._values))

    def __copy__(self):
        return _restored(self._type, dict(self._values))

    def __deepcopy__(self, memo):
        return copy(self)

    def __bytes__(self):
        return self._type.to_cdr(self)


def _message_of(nested, value):
    """Returns a message if the value is a mapping, so that its fields are attributes. Returns other values
    unchanged."""
    return Message(nested, **value) if isinstance(value, dict) else value


def _restored(of_type, values):
    message = Message(of_type)
    message._values.update(values)
    return message


def _default(member):
    _, kind, shape, count, _, _, nested = member
    single = {"struct": lambda: Message(nested), "string": str, "char": lambda: "\0", "bool": bool,
              "float32": float, "float64": float}.get(kind, int)
    if shape == "single":
        return single()
    if kind in ("struct", "string"):
        return [single() for _ in range(count if shape == "array" else 0)]
    dtype = {"byte": "uint8", "char": "S1"}.get(kind, kind)
    return np.zeros(count if shape == "array" else 0, dtype)


def _fields(of):
    """Yields names and values. For absent fields of a sample it yields an Absent, and does not request them."""
    for name in of._names:
        yield name, Absent(name, False) if of._is_absent(name) else getattr(of, name)


def copy(of):
    """Returns a new message with the fields of a sample, of a struct in a sample, or of a message. Absent fields stay
    absent."""
    return _copy_as(of._type if isinstance(of, Message) else _part(_sft.Type(of._message_type), of._type_name), of)


def _copy_as(of_type, of):
    nested = {member[0]: member[-1] for member in of_type._members}
    return _restored(of_type, {name: _copied(nested[name], value) for name, value in _fields(of)})


def _copied(nested, value):
    if isinstance(value, (Message, _sft.View)):
        return _copy_as(nested, value)
    if isinstance(value, (list, tuple)):
        return [_copied(nested, element) for element in value]
    return value.copy() if isinstance(value, np.ndarray) else value


def _part(whole, name):
    """Returns the type of this name: a whole type, or the type of a struct in it."""
    waiting = [whole]
    for candidate in waiting:
        if candidate.name == name:
            return candidate
        waiting.extend(member[-1] for member in candidate._members if member[-1] is not None)
    raise AssertionError(name)


def equal(one, other):
    """Returns true if all fields of two messages or samples are equal. Arrays are compared element by element."""
    if not isinstance(other, (Message, _sft.View)):
        return NotImplemented
    if one._type_name != other._type_name:
        return False
    return all(_equal(getattr(one, name), getattr(other, name)) for name in one._names)


def _equal(a, b):
    if isinstance(a, Absent) or isinstance(b, Absent):
        return isinstance(a, Absent) and isinstance(b, Absent)
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return np.array_equal(a, b)
    if isinstance(a, (list, tuple)) and isinstance(b, (list, tuple)):
        return len(a) == len(b) and all(map(_equal, a, b))
    return a == b


def text(of):
    """Returns the text for repr(): 'PointCloud2(header=Header(...), height=1, data=<6291456 x uint8>)'."""
    fields = ", ".join(f"{name}={_text(value)}" for name, value in _fields(of))
    return f"{of._type_name.rpartition('/')[2]}({fields})"


def _text(value):
    if isinstance(value, Absent):
        return "<absent>"
    if isinstance(value, np.ndarray) and value.size > _SHOWN:
        return f"<{value.size} x {value.dtype}>"
    if isinstance(value, np.ndarray):
        return str(value.tolist())
    if isinstance(value, (list, tuple)):
        more = f", ... {len(value) - _SHOWN} more" if len(value) > _SHOWN else ""
        return "[" + ", ".join(map(_text, value[:_SHOWN])) + more + "]"
    return repr(value)


_ENCODINGS = {"mono8": ("u1", 1), "mono16": ("u2", 1), "rgb8": ("u1", 3), "bgr8": ("u1", 3), "rgba8": ("u1", 4),
              "bgra8": ("u1", 4), "rgb16": ("u2", 3), "bgr16": ("u2", 3), "rgba16": ("u2", 4), "bgra16": ("u2", 4)}
_DEPTHS = {"8U": "u1", "8S": "i1", "16U": "u2", "16S": "i2", "32S": "i4", "32F": "f4", "64F": "f8"}


def _pixel(encoding):
    """Returns the dtype of a channel and the number of channels, for the encodings of sensor_msgs/Image."""
    if encoding in _ENCODINGS:
        return _ENCODINGS[encoding]
    if encoding.startswith("bayer_"):
        return ("u2" if encoding.endswith("16") else "u1"), 1
    depth, _, channels = encoding.partition("C")
    if depth in _DEPTHS and channels.isdigit() and int(channels) > 0:
        return _DEPTHS[depth], int(channels)
    raise ValueError(f"image(): the encoding '{encoding}' has no channels that numpy knows: read data")


def image(of):
    """Returns the pixels of a sensor_msgs/Image as height x width x channels, over the memory of the sample. Images of
    one channel are height x width."""
    encoding = of.encoding
    if isinstance(encoding, Absent):
        of.data  # this asks for it, too
        return encoding
    dtype, channels = _pixel(encoding)
    found = of._cells("data", np.dtype(dtype).itemsize * channels)
    if isinstance(found, Absent):
        return found
    pixels, is_swapped = found
    height = of.height
    pixels = pixels.reshape(height, -1, pixels.shape[-1]) if pixels.ndim == 2 else pixels
    values = pixels.view(np.dtype(dtype).newbyteorder(">" if is_swapped else "<"))
    return values[..., 0] if channels == 1 else values


def cells(of, path):
    """Returns the elements of a field as rows x columns, over the memory of the sample: the cells of a map."""
    values = of.find(path)
    if isinstance(values, Absent):
        return values
    found = of._cells(path, values.dtype.itemsize)
    return found if isinstance(found, Absent) else found[0].view(values.dtype)[..., 0]


def _refuse_to_set(_, name, __=None):
    raise AttributeError(f"a sample is read-only: set '{name}' of its copy()")


def _type_call(self, **values):
    return Message(self, **values)


def _view_reduce(self, *_):
    return copy(self).__reduce__()


Message.__repr__ = _sft.View.__repr__ = text
Message.__eq__ = _sft.View.__eq__ = equal
_sft.View.__hash__ = None
_sft.View.__setattr__ = _sft.View.__delattr__ = _refuse_to_set
_sft.View.__str__ = _sft.View.to_yaml
_sft.View.__reduce_ex__ = _view_reduce
_sft.View.__copy__ = copy
_sft.View.__deepcopy__ = lambda self, memo: copy(self)
_sft.View.copy = copy
_sft.View.image = image
_sft.View.cells = cells
_sft.Type.__call__ = _type_call
_sft.Type.__repr__ = lambda self: f"<sft.Type {self.name}>"
_sft.Type.__str__ = lambda self: self.msg
_sft.Type.__eq__ = lambda self, other: isinstance(other, _sft.Type) and self._key == other._key
_sft.Type.__hash__ = lambda self: hash(self.name)
_sft.Type.__reduce__ = lambda self: (_parsed, self._key)


def _parsed(name, description):
    return _part(_sft.Type(_sft.parse_type(description)), name)
