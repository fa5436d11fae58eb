"""Prints stubs (.pyi) of message types, from which editors and type checkers know the fields:

    python3 -m sft.stubs sensor_msgs/PointCloud2 nav_msgs/Odometry >messages.pyi
"""

import keyword
import sys

from sft import find_type

_NUMPY = {"bool": "bool_", "byte": "uint8", "char": "bytes_"}  # others have the same name in numpy
_PYTHON = {"bool": "bool", "char": "str", "string": "str", "float32": "float", "float64": "float"}


def _annotation(kind, shape, nested_class):
    if kind in ("string", "struct"):
        one = nested_class or "str"
        return one if shape == "single" else f"tuple[{one}, ...]"
    return _PYTHON.get(kind, "int") if shape == "single" else f"NDArray[np.{_NUMPY.get(kind, kind)}]"


def _class_name(type, others):
    package, _, name = type.name.rpartition("/")
    return name if all(other.name.rpartition("/")[2] != name for other in others) else f"{package}_{name}"


def stubs(types):
    """Returns the text of a .pyi file with a class for each of the types and each of their nested types."""
    names, classes = {}, []

    def add(type, base):
        if type.name in names:
            return names[type.name]
        name = names[type.name] = _class_name(type, [known for known, _ in classes])
        lines = [f"class {name}({base}):"]
        classes.append((type, lines))
        for field, kind, shape, count, bound, unit, nested in type._members:
            if keyword.iskeyword(field):
                continue  # no class can declare it
            annotation = _annotation(kind, shape, add(nested, "sft.View") if nested else None)
            size = {"array": f"{count} elements", "sequence": f"at most {bound}" if bound else ""}.get(shape, "")
            comment = ", ".join(part for part in (size, unit and f"[{unit}]") if part)
            lines.append(f"    {field}: {annotation}" + (f"  # {comment}" if comment else ""))
        if len(lines) == 1:
            lines.append("    pass")
        return name

    for type in types:
        add(type, "sft.Sample")
    head = "import numpy as np\nfrom numpy.typing import NDArray\n\nimport sft\n"
    return head + "".join("\n" + "\n".join(lines) + "\n" for _, lines in classes)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    print(stubs([find_type(name) for name in sys.argv[1:]]), end="")
