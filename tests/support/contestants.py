"""Writes C++ files that list generated types: as test::contestants(), together with the types that the original idlc
makes (contestant.h), or without --cyclone as test::generated_types() (message_types.h)."""
import argparse
import pathlib
import re
import sys

arguments = argparse.ArgumentParser(description=__doc__)
arguments.add_argument("--cyclone", type=pathlib.Path, help="below it are C files of stock idlc")
arguments.add_argument("--headers", nargs="+", action="append", required=True, metavar=("INCLUDE_DIR", "HEADER"),
                       help="generated headers below INCLUDE_DIR: all types in them are listed")
arguments.add_argument("--views", action="store_true", help="also instantiate all getters of all views")
arguments.add_argument("--ours-only", nargs="*", default=[], metavar="NAME",
                       help="names of headers whose types stock idlc may lack")
arguments.add_argument("outputs", nargs="+", type=pathlib.Path, help="the first one joins the others")
arguments = arguments.parse_args()

# Topic descriptors by the IDL names of their types.
descriptors = {}
for file in arguments.cyclone.rglob("*.c") if arguments.cyclone else []:
    pattern = r'^const dds_topic_descriptor_t (\w+) =.*?[.]m_typename = "([^"]+)"'
    descriptors.update((name, symbol) for symbol, name in re.findall(pattern, file.read_text(), re.M | re.S))


def types(header):
    """Returns pairs of the C++ name of a type and its topic descriptor, or None if it has none."""
    pattern = r'^struct sft::detail::TypeTable<([^>]+)> {.*?StructType type{"([^"]+)"'
    found = re.findall(pattern, header.read_text(), re.M | re.S)
    # Stock idlc knows the request and the response of a service, but not the types that carry them.
    carriers = ("_Call", "_Reply") if header.parent.name == "srv" else ()
    missing = [idl for _, idl in found if idl not in descriptors and not idl.endswith(carriers)]
    if arguments.cyclone and missing and header.name not in arguments.ours_only:
        sys.exit(f"stock idlc made nothing of {', '.join(missing)}, which {header} has")
    return [(cpp, descriptors.get(idl)) for cpp, idl in found]


if arguments.cyclone:
    list_header, element, function = "contestant.h", "Contestant", "contestants"
else:
    list_header, element, function = "message_types.h", "MessageType", "generated_types"


def entry(ours, theirs):
    message_type = f"message_type<{ours}>()"
    return f"{{{message_type}, {f'&{theirs}' if theirs else 'nullptr'}}}" if arguments.cyclone else message_type


def views(ours):
    """Returns code that instantiates the views of full and recorded samples, for a message and for an element."""
    requirements = (f"sft::Req<{ours}>{{sft::all<{ours}>}}", f"sft::Req<{ours}>{{sft::recorded}}")
    places = ("sft::detail::IndexedPlace<{0}, {1}, 0, 0>", "sft::detail::ElementPlace<{0}, {1}, 0>")
    return "".join(f"template class {ours}::View<{place.format(requirement, ours)}>;\n"
                   for requirement in requirements for place in places)


def part(number, headers):
    """Returns the text of one file. `headers`: pairs of an include directory and a path."""
    listed = [both for _, header in headers for both in types(header)]
    return f"""\
// Generated. Do not edit.
#include "tests/support/{list_header}"

{"".join(f"#include <{header.relative_to(root)}>{chr(10)}" for root, header in headers)}
extern "C" {{
{"".join(f"extern const dds_topic_descriptor_t {theirs};{chr(10)}" for _, theirs in listed if theirs)}\
}}

namespace sft::test {{

void add_{function}_{number}(std::vector<{element}>& all) {{
{"".join(f"  all.push_back({entry(*both)});{chr(10)}" for both in listed)}\
}}

}}  // namespace sft::test
{"".join(views(ours) for ours, _ in listed) if arguments.views else ""}"""


def joined(parts):
    return f"""\
// Generated. Do not edit.
#include "tests/support/{list_header}"

namespace sft::test {{

{"".join(f"void add_{function}_{number}(std::vector<{element}>& all);{chr(10)}" for number in range(parts))}
std::vector<{element}> {function}() {{
  std::vector<{element}> all;
{"".join(f"  add_{function}_{number}(all);{chr(10)}" for number in range(parts))}\
  return all;
}}

}}  // namespace sft::test
"""


headers = sorted((pathlib.Path(root), pathlib.Path(header))
                 for root, *of_root in arguments.headers for header in of_root)
join, *parts = arguments.outputs
join.write_text(joined(len(parts)))
for number, output in enumerate(parts):
    output.write_text(part(number, headers[number::len(parts)]))
