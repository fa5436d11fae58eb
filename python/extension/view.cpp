#include "python/extension/view.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <span>
#include <variant>

#include "python/extension/arrays.h"
#include "python/extension/failure.h"
#include "python/extension/gil.h"

namespace sft::python {

namespace {

/// Calls `read` with a value of the C++ type for numbers of this kind, as in DynamicView::as().
template <class Read>
auto with_type_of(Kind kind, Read&& read) {
  switch (kind) {
    case Kind::character:
      return read.template operator()<char>();
    case Kind::int8:
      return read.template operator()<std::int8_t>();
    case Kind::int16:
      return read.template operator()<std::int16_t>();
    case Kind::uint16:
      return read.template operator()<std::uint16_t>();
    case Kind::int32:
      return read.template operator()<std::int32_t>();
    case Kind::uint32:
      return read.template operator()<std::uint32_t>();
    case Kind::int64:
      return read.template operator()<std::int64_t>();
    case Kind::uint64:
      return read.template operator()<std::uint64_t>();
    case Kind::float32:
      return read.template operator()<float>();
    case Kind::float64:
      return read.template operator()<double>();
    default:
      return read.template operator()<std::uint8_t>();
  }
}

struct ToPython {
  py::object operator()(bool value) const { return py::bool_(value); }
  py::object operator()(char value) const {
    return py::reinterpret_steal<py::object>(PyUnicode_DecodeLatin1(&value, 1, nullptr));
  }
  py::object operator()(std::int64_t value) const { return py::int_(value); }
  py::object operator()(std::uint64_t value) const { return py::int_(value); }
  py::object operator()(float value) const { return py::float_(value); }
  py::object operator()(double value) const { return py::float_(value); }
  py::object operator()(std::string_view value) const { return text_of(value); }
};

std::vector<std::string_view> views_of(const std::vector<std::string>& names) {
  return {names.begin(), names.end()};
}

/// The shape and the strides of an array over cells. If there is only one row, the array has one dimension.
struct Grid {
  explicit Grid(const Strides& cells) {
    if (cells.rows != 1) {
      shape.push_back(static_cast<py::ssize_t>(cells.rows));
      steps.push_back(static_cast<py::ssize_t>(cells.row_step));
    }
    shape.push_back(static_cast<py::ssize_t>(cells.columns));
    steps.push_back(static_cast<py::ssize_t>(cells.column_step));
  }
  std::vector<py::ssize_t> shape;
  std::vector<py::ssize_t> steps;
};

/// Returns an attribute of a view: a field of the sample, or an attribute of the class.
py::object attribute(PyObject* self, PyObject* name) {
  // The view is the only C++ object of `self`, and the first base class of Sample. It is missing after a
  // direct call of View.__new__.
  const auto* const view =
      reinterpret_cast<py::detail::instance*>(self)->get_value_and_holder().value_ptr<View>();
  const auto text = py::handle(name).cast<std::string_view>();
  if (view != nullptr && view->has(text)) return view->member(text);
  PyObject* const found = PyObject_GenericGetAttr(self, name);
  if (found != nullptr) return py::reinterpret_steal<py::object>(found);
  if (view == nullptr || text.starts_with('_') || PyErr_ExceptionMatches(PyExc_AttributeError) == 0)
    throw py::error_already_set();
  PyErr_Clear();
  throw py::attribute_error(view->view()[text].error()->message);
}

/// The function that Python calls for each access to an attribute, and so for each access to a field. It
/// does not use the overloads of pybind11, which would take longer than the access itself.
PyObject* get_attribute(PyObject* self, PyObject* name) noexcept {
  try {
    try {
      return attribute(self, name).release().ptr();
    } catch (const Failure& failure) {
      raise_failure(failure);
    }
  } catch (py::error_already_set& error) {
    error.restore();
  } catch (const py::builtin_exception& error) {
    error.set_error();
  } catch (const std::exception& error) {
    PyErr_SetString(PyExc_RuntimeError, error.what());
  }
  return nullptr;
}

py::list names_of(const View& view) {
  py::list names;
  for (const StructType::Member& member : view.type().members) names.append(text_of(member.name));
  return names;
}

std::vector<std::string> names_in(const py::args& names) { return names.cast<std::vector<std::string>>(); }

std::int64_t nanoseconds(std::chrono::sys_time<std::chrono::nanoseconds> time) {
  return time.time_since_epoch().count();
}

void define_info(py::module_& module) {
  py::class_<SampleInfo>(module, "SampleInfo", "The origin of a sample. Stamps are in ns since 1970.")
      .def_readonly("sequence", &SampleInfo::sequence, "Number of the sample of its publisher, from 1.")
      .def_readonly("publisher", &SampleInfo::writer, "Id of the publisher.")
      .def_readonly("lost_before", &SampleInfo::lost_before,
                    "Samples of this publisher that were lost before this one.")
      .def_readonly("selection", &SampleInfo::selection, "Number of the selection that it came for.")
      .def_property_readonly(
          "source_stamp", [](const SampleInfo& i) { return nanoseconds(i.source_stamp); },
          "Time of publish(), by the publisher's clock [ns].")
      .def_property_readonly(
          "receive_stamp", [](const SampleInfo& i) { return nanoseconds(i.receive_stamp); },
          "Time at which the sample was complete here [ns].")
      .def_property_readonly(
          "transport", [](const SampleInfo& i) { return to_string(i.transport); }, "'shm', 'udp' or 'dds'.");
}

}  // namespace

py::str text_of(std::string_view text) {
  PyObject* const decoded =
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "replace");
  if (decoded == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(decoded);
}

std::string short_name(std::string_view name) {
  std::string text(name);
  for (const std::string_view part : {"::msg::", "::"})
    for (std::size_t at = 0; (at = text.find(part)) != text.npos;) text.replace(at, part.size(), "/");
  return text;
}

bool View::has(std::string_view member) const {
  return std::ranges::find(type().members, member, &StructType::Member::name) != type().members.end();
}

std::string View::path_of(std::string_view member) const {
  return path_.empty() ? std::string(member) : path_ + "." + std::string(member);
}

py::object View::absent(const std::string& path) const {
  return py::module_::import("sft._absent").attr("Absent")(path, held_->is_recorded());
}

py::object View::absent_or_throw(const Error& error, const std::string& path) const {
  if (error.code != Errc::unavailable) throw Failure(error);
  return absent(path);
}

py::object View::value(const DynamicView& view, std::string path) const {
  if (view.error() != nullptr) throw Failure(*view.error());
  // A struct is returned as a view even if the sample lacks it. So only the members that are then read are
  // requested.
  if (view.is_struct()) return py::cast(View(held_, view, std::move(path)));
  if (view.is_collection()) {
    return is_number(view.kind()) ? number_array(view, path) : elements(view, path);
  }
  const Result<DynamicView::Scalar> scalar = view.scalar();
  if (!scalar) return absent_or_throw(scalar.error(), path);
  return std::visit(ToPython(), *scalar);
}

py::object View::number_array(const DynamicView& view, const std::string& path) const {
  return with_type_of(view.kind(), [&]<class E>() -> py::object {
    const auto numbers = view.as<std::span<const E>>();
    if (!numbers) return absent_or_throw(numbers.error(), path);
    return array_over(numbers->data(), py::dtype(dtype_text(view.kind())),
                      {static_cast<py::ssize_t>(numbers->size())}, {sizeof(E)}, keep(held_));
  });
}

py::object View::elements(const DynamicView& view, const std::string& path) const {
  const Result<std::size_t> size = view.size();
  if (!size) return absent_or_throw(size.error(), path);
  py::list all;
  for (const DynamicView& element : view.elements())
    all.append(value(element, path + "[" + std::to_string(all.size()) + "]"));
  if (all.size() < *size) return absent(path);  // the sample has only the number of elements
  return py::tuple(all);
}

py::object View::size(std::string_view path) const {
  const Result<std::size_t> size = view_.find(path).size();
  if (!size) return absent_or_throw(size.error(), path_of(path));
  return py::int_(*size);
}

/// Returns the points with the channels `names`. If there are no names, returns them with all channels, and
/// sets `names`.
Result<Strides> View::strides(std::vector<std::string>& names) const {
  if (names.empty()) {
    for (const DynamicView& channel : view_["fields"].elements()) {
      const auto name = channel["name"].as<std::string>();
      const auto type = channel["datatype"].as<std::uint8_t>();
      const auto count = channel["count"].as<std::uint32_t>();
      if (!name) return tl::unexpected(name.error());
      if (!type || !count) return tl::unexpected(type ? count.error() : type.error());
      const bool has_numbers = *type >= 1 && *type <= 8 && *count > 0;
      if (has_numbers && std::ranges::find(names, *name) == names.end()) names.push_back(*name);
    }
  }
  return point_strides_of(view_, views_of(names));
}

py::array View::over(const Strides& strides, const py::dtype& type, std::size_t offset,
                     std::vector<py::ssize_t> inner, py::ssize_t inner_step) const {
  Grid grid(strides);
  for (const py::ssize_t dimension : inner) {
    grid.shape.push_back(dimension);
    grid.steps.push_back(inner_step);
  }
  return array_over(strides.first + offset, type, std::move(grid.shape), std::move(grid.steps), keep(held_));
}

py::object View::points(const std::vector<std::string>& channels) const {
  std::vector<std::string> names = channels;
  const Result<Strides> cloud = strides(names);
  if (!cloud) return absent_or_throw(cloud.error(), path_of("points"));
  py::list keys, formats, offsets;
  std::size_t bytes = cloud->column_step;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Strides::Channel& channel = cloud->channels[i];
    const py::str format(dtype_text(channel.kind, cloud->is_swapped));
    keys.append(text_of(names[i]));
    formats.append(channel.count == 1 ? py::object(format)
                                      : py::object(py::make_tuple(format, py::make_tuple(channel.count))));
    offsets.append(channel.offset);
    bytes = std::max(bytes, channel.offset + bytes_of(channel.kind) * channel.count);
  }
  const py::dtype point(keys, formats, offsets, static_cast<py::ssize_t>(bytes));
  return over(*cloud, point, 0, {}, 0);
}

py::object View::columns(const std::vector<std::string>& channels) const {
  std::vector<std::string> names = channels;
  const Result<Strides> cloud = strides(names);
  if (!cloud) return absent_or_throw(cloud.error(), path_of("points"));
  py::list all;
  for (const Strides::Channel& channel : cloud->channels) {
    std::vector<py::ssize_t> inner;
    if (channel.count != 1) inner.push_back(channel.count);
    all.append(over(*cloud, py::dtype(dtype_text(channel.kind, cloud->is_swapped)), channel.offset,
                    std::move(inner), static_cast<py::ssize_t>(bytes_of(channel.kind))));
  }
  return py::tuple(all);
}

py::object View::cells(const std::string& path, std::size_t cell_bytes) const {
  const Result<Strides> found = strides_of(view_, path, cell_bytes);
  if (!found) return absent_or_throw(found.error(), path_of(path));
  return py::make_tuple(over(*found, py::dtype("u1"), 0, {static_cast<py::ssize_t>(cell_bytes)}, 1),
                        found->is_swapped);
}

void define_views(py::module_& module) {
  define_info(module);
  const py::custom_type_setup with_slot(
      [](PyHeapTypeObject* type) { type->ht_type.tp_getattro = get_attribute; });
  py::class_<View>(module, "View", with_slot,
                   "A struct of a sample. Its fields are attributes; arrays are not copied.")
      .def("__dir__", names_of)
      .def("find", &View::find, py::arg("path"), "Returns the value at a path, such as 'fields[0].name'.")
      .def("size", &View::size, py::arg("path"),
           "Returns the number of elements of an array or a sequence. It is sent with 'name.size', too.")
      .def(
          "points", [](const View& v, const py::args& names) { return v.points(names_in(names)); },
          "points('x', 'y', 'z'): the points of a cloud as one structured array over its memory, height x\n"
          "width where the cloud is organised. Without names it has all channels.")
      .def(
          "columns", [](const View& v, const py::args& names) { return v.columns(names_in(names)); },
          "columns('x', 'y', 'z'): the channels of a cloud, each as an array over its memory.")
      .def(
          "to_yaml", [](const View& v) { return value_of(to_yaml(v.view())); }, "All present fields as YAML.")
      .def(
          "to_json", [](const View& v) { return value_of(to_json(v.view())); }, "All present fields as JSON.")
      .def("_cells", &View::cells)
      .def("_is_absent", &View::is_absent)
      .def_property_readonly("_names", names_of)
      .def_property_readonly("_type_name", [](const View& v) { return short_name(v.type().name); })
      .def_property_readonly("_topic", [](const View& v) { return text_of(v.held().topic()); })
      .def_property_readonly("_message_type", [](const View& v) { return v.held().sample().type(); });
  py::class_<Sample, View>(module, "Sample", "A sample as it was received. It has the fields of its message.")
      .def_property_readonly(
          "info", [](const Sample& s) { return s.held().sample().info(); }, "Its origin: sft.SampleInfo.")
      .def(
          "to_cdr",
          [](const Sample& s) {
            const auto bytes = s.held().sample().cdr();
            return bytes_with(bytes.size(),
                              [&](std::byte* to) { std::memcpy(to, bytes.data(), bytes.size()); });
          },
          "The present fields as CDR with its encapsulation, copied. This is no read.");
}

}  // namespace sft::python
