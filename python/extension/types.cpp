#include "python/extension/types.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <span>
#include <vector>

#include "python/extension/encoder.h"
#include "python/extension/failure.h"
#include "python/extension/gil.h"
#include "python/extension/view.h"
#include "sft/msg_text.h"

namespace sft::python {

namespace {

using Roots = std::vector<std::string>;

/// The user's own files are not hostile. So their types may nest deeper than types that other nodes
/// announce.
constexpr DynamicType::Limits limits_of_files{.bytes = std::size_t{1} << 20, .depth = 64};

constexpr const char* kind_names[] = {"bool",   "byte",    "char",    "int8",   "uint8",
                                      "int16",  "uint16",  "int32",   "uint32", "int64",
                                      "uint64", "float32", "float64", "string", "struct"};
constexpr const char* shape_names[] = {"single", "array", "sequence"};

std::vector<std::filesystem::path> paths_of(const Roots& roots) { return {roots.begin(), roots.end()}; }

DynamicType parse(const py::bytes& description) {
  const auto text = description.cast<std::string_view>();
  return value_of(DynamicType::parse(std::as_bytes(std::span(text.data(), text.size())), limits_of_files));
}

}  // namespace

std::string PyType::name() const { return short_name(type_->name); }

const DynamicType& PyType::whole() const {
  if (type_ == &root_.type()) return root_;
  throw Failure({Errc::invalid_argument, name() + " is a part of " + short_name(root_.name()) +
                                             ": look for the type by its name, sft.find_type('" + name() +
                                             "')"});
}

py::list PyType::members() const {
  py::list all;
  for (const StructType::Member& m : type_->members) {
    const py::object nested = m.type == nullptr ? py::object(py::none()) : py::cast(PyType(root_, *m.type));
    all.append(py::make_tuple(text_of(m.name), kind_names[static_cast<std::size_t>(m.kind)],
                              shape_names[static_cast<std::size_t>(m.shape)], m.count, m.bound,
                              text_of(m.unit), nested));
  }
  return all;
}

py::tuple PyType::key() const {
  const auto bytes = root_.description();
  return py::make_tuple(name(), py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

void PyType::check(const std::string& member, const py::handle& value) const {
  const auto found = std::ranges::find(type_->members, member, &StructType::Member::name);
  if (found != type_->members.end()) Encoder().member(*found, value, member);
}

py::bytes PyType::encode(const py::handle& message) const {
  constexpr std::size_t encapsulation_bytes = 4;
  const Plan plan = Encoder().message(*type_, message);
  return bytes_with(encapsulation_bytes + plan.bytes(), [&](std::byte* to) {
    constexpr std::byte encapsulation[encapsulation_bytes]{{}, std::byte{1}};  // little-endian CDR
    std::memcpy(to, encapsulation, encapsulation_bytes);
    plan.write({to + encapsulation_bytes, plan.bytes()}, true);
  });
}

void define_types(py::module_& module) {
  py::class_<DynamicType>(module, "DynamicType");
  py::class_<PyType>(module, "Type", "A message type. Call it to make a message: Twist(linear={'x': 1}).")
      .def(py::init<DynamicType>())
      .def_property_readonly("name", &PyType::name, "'sensor_msgs/PointCloud2'")
      .def_property_readonly(
          "hash", [](const PyType& t) { return t.whole().hash(); }, "Equal for equal types.")
      .def_property_readonly(
          "msg", [](const PyType& t) { return value_of(to_msg(t.whole())); },
          "The definition as .msg text, with those of all nested messages.")
      .def_property_readonly("_whole", &PyType::whole)
      .def_property_readonly("_members", &PyType::members)
      .def_property_readonly("_key", &PyType::key)
      .def("_check", &PyType::check)
      .def("to_cdr", &PyType::encode, py::arg("message"),
           "Returns a message as CDR, with 4 bytes of encapsulation, as bags have it.");
  module.def("parse_type", parse);
  module.def("find_msg", [](const std::string& name, const Roots& roots) {
    return value_of(find_msg(name, paths_of(roots), limits_of_files));
  });
  module.def("from_msg", [](const std::string& name, const std::string& text) {
    return value_of(from_msg(name, text, limits_of_files));
  });
  module.def("from_msg_file", [](const std::string& file, const Roots& roots) {
    return value_of(from_msg_file(file, paths_of(roots), limits_of_files));
  });
}

}  // namespace sft::python
