#include "python/extension/encoder.h"

#include <pybind11/numpy.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string_view>

#include "python/extension/arrays.h"
#include "python/extension/view.h"
#include "sft/time.h"

namespace sft::python {

namespace {

/// The limit of the format: a length has 32 bits. Samples are always shorter.
constexpr std::size_t count_max = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t shown_max = 60;

struct TimeMessage {
  std::int32_t sec;
  std::uint32_t nanosec;
};

std::string_view text_in(const py::handle& text) {
  py::ssize_t bytes = 0;
  const char* const data = PyUnicode_AsUTF8AndSize(text.ptr(), &bytes);
  if (data == nullptr) throw py::error_already_set();
  return {data, static_cast<std::size_t>(bytes)};
}

/// Returns the items of a mapping as a dictionary.
py::dict values_of(const py::handle& value) {
  if (PyDict_Check(value.ptr())) return py::reinterpret_borrow<py::dict>(value);
  return py::dict(py::reinterpret_borrow<py::object>(value));
}

bool is_mapping(const py::handle& value) {
  return PyDict_Check(value.ptr()) ||
         (PyMapping_Check(value.ptr()) && py::hasattr(value, "keys") && !PyUnicode_Check(value.ptr()));
}

bool is_instance(const py::handle& value, const char* module, const char* name) {
  return py::isinstance(value, py::module_::import(module).attr(name));
}

/// Returns false for texts, bytes, and objects without an order or a length.
bool is_list(const py::handle& value) {
  PyObject* const p = value.ptr();
  return PySequence_Check(p) && !PyUnicode_Check(p) && !PyBytes_Check(p) && !PyByteArray_Check(p) &&
         !PyDict_Check(p);
}

}  // namespace

/// Makes the encoder visit a field. While this object exists, errors name the path of this field.
class Encoder::Step {
 public:
  Step(std::string& path, std::string_view name) : path_(path), length_(path.size()) {
    if (!path.empty()) path += '.';
    path += name;
  }
  Step(std::string& path, std::size_t i) : path_(path), length_(path.size()) {
    path += '[' + std::to_string(i) + ']';
  }
  Step(const Step&) = delete;
  Step& operator=(const Step&) = delete;
  ~Step() { path_.resize(length_); }

 private:
  std::string& path_;
  std::size_t length_;
};

Plan Encoder::message(const StructType& type, const py::handle& value) {
  put_struct(type, value);
  return std::move(plan_);
}

Plan Encoder::member(const StructType::Member& member, const py::handle& value, const std::string& path) {
  path_ = path;
  put_member(member, value);
  return std::move(plan_);
}

void Encoder::refuse(PyObject* exception, const py::handle& value, const std::string& expected) const {
  const bool is_absent = is_instance(value, "sft._absent", "Absent");
  if (is_absent) value.attr("_refuse")();  // raises an error that names the field of the sample
  std::string shown = py::repr(value).cast<std::string>();
  if (shown.size() > shown_max) shown = shown.substr(0, shown_max) + "...";
  const std::string path = path_.empty() ? "the message" : "'" + path_ + "'";
  PyErr_SetString(exception, (path + " is " + shown + "; " + expected + " was expected").c_str());
  throw py::error_already_set();
}

void Encoder::refuse_count(const Member& member, std::size_t count) const {
  const std::string expected = member.shape == Shape::array ? std::to_string(member.count) + " were expected"
                                                            : "it may have " + std::to_string(member.bound);
  PyErr_SetString(PyExc_ValueError,
                  ("'" + path_ + "' has " + std::to_string(count) + " elements; " + expected).c_str());
  throw py::error_already_set();
}

template <class Number>
void Encoder::put_value(Number number) {
  plan_.align(sizeof number);
  plan_.put(&number, sizeof number);
}

// ---- structs ----

void Encoder::put_struct(const StructType& type, const py::handle& value) {
  if (!value || is_mapping(value)) return put_mapping(type, value ? values_of(value) : py::dict());
  if (is_instance(value, "sft._message", "Message")) {
    if (value.attr("_type").attr("name").cast<std::string>() != short_name(type.name))
      refuse(PyExc_TypeError, value, "a " + short_name(type.name));
    return put_mapping(type, value.attr("_values"));
  }
  if (put_word(type, value)) return;
  for (const Member& member : type.members) {
    const Step step(path_, member.name);
    const py::str name = text_of(member.name);
    PyObject* const found = PyObject_GetAttr(value.ptr(), name.ptr());
    if (found == nullptr) {
      if (PyErr_ExceptionMatches(PyExc_AttributeError) == 0) throw py::error_already_set();
      PyErr_Clear();
      refuse(PyExc_TypeError, value, "a mapping or an object with the fields of " + short_name(type.name));
    }
    put_member(member, py::reinterpret_steal<py::object>(found));
  }
}

void Encoder::put_mapping(const StructType& type, const py::dict& values) {
  std::size_t used = 0;
  for (const Member& member : type.members) {
    const Step step(path_, member.name);
    const py::str name = text_of(member.name);
    PyObject* const found = PyDict_GetItemWithError(values.ptr(), name.ptr());
    if (found == nullptr && PyErr_Occurred() != nullptr) throw py::error_already_set();
    used += found != nullptr ? 1 : 0;
    // The value must be kept, because a list may change while it is read.
    put_member(member, py::reinterpret_borrow<py::object>(found));
  }
  if (used == values.size()) return;
  py::list names;
  for (const Member& member : type.members) names.append(text_of(member.name));
  py::module_::import("sft._fit").attr("refuse_unknown")(values, names, short_name(type.name), path_);
}

/// Puts the present time if the value is a word that JSON also allows: "now" for a time, or "auto" for a
/// header. Returns false if it is not.
bool Encoder::put_word(const StructType& type, const py::handle& value) {
  if (!PyUnicode_Check(value.ptr())) return false;
  const bool is_time = type.name == "builtin_interfaces::msg::Time" && text_in(value) == "now";
  const bool is_header = type.name == "std_msgs::msg::Header" && text_in(value) == "auto";
  if (!is_time && !is_header) return false;
  const auto now = time_message<TimeMessage>(std::chrono::system_clock::now());
  put_mapping(type, is_time ? py::dict(py::arg("sec") = now.sec, py::arg("nanosec") = now.nanosec)
                            : py::dict(py::arg("stamp") = "now"));
  return true;
}

void Encoder::put_member(const Member& member, const py::handle& value) {
  const bool is_number_field = is_number(member.kind);
  if (member.shape == Shape::single) return put_single(member, value);
  if (!is_number_field) return put_elements(member, value);
  if (makes_room_ && value && member.shape == Shape::sequence && PyLong_Check(value.ptr()))
    return put_room(member, value);
  put_numbers(member, value);
}

void Encoder::put_single(const Member& member, const py::handle& value) {
  if (member.kind == Kind::structure) return put_struct(*member.type, value);
  if (member.kind == Kind::string) return put_text(member, value);
  plan_.align(bytes_of(member.kind));
  if (makes_room_) plan_.note({path_, &member, plan_.bytes(), 1});
  if (value) return put_number(member, value);
  plan_.put_zeros(bytes_of(member.kind));
}

// ---- single values ----

void Encoder::put_text(const Member& member, const py::handle& value) {
  std::string_view text;
  if (value && !PyUnicode_Check(value.ptr())) refuse(PyExc_TypeError, value, "a text");
  if (value) text = text_in(value);
  if (text.find('\0') != text.npos) refuse(PyExc_ValueError, value, "a text without NUL");
  if (member.string_bound > 0 && text.size() > member.string_bound)
    refuse(PyExc_ValueError, value, "a text of at most " + std::to_string(member.string_bound) + " bytes");
  put_value(static_cast<std::uint32_t>(text.size() + 1));
  plan_.put(text.data(), text.size());
  plan_.put_zeros(1);
}

void Encoder::put_number(const Member& member, const py::handle& value) {
  switch (member.kind) {
    case Kind::boolean: {
      const bool is_bool =
          PyBool_Check(value.ptr()) ||
          py::str(py::type::handle_of(value).attr("__name__")).cast<std::string>().starts_with("bool");
      if (!is_bool) refuse(PyExc_TypeError, value, "True or False");
      return put_value(static_cast<std::uint8_t>(PyObject_IsTrue(value.ptr()) == 1));
    }
    case Kind::character: {
      if (!PyUnicode_Check(value.ptr()) || text_in(value).size() != 1)
        refuse(PyExc_TypeError, value, "a text of one character of ASCII");
      return put_value(text_in(value).front());
    }
    case Kind::int8:
      return put_integer<std::int8_t>(member, value);
    case Kind::octet:
    case Kind::uint8:
      return put_integer<std::uint8_t>(member, value);
    case Kind::int16:
      return put_integer<std::int16_t>(member, value);
    case Kind::uint16:
      return put_integer<std::uint16_t>(member, value);
    case Kind::int32:
      return put_integer<std::int32_t>(member, value);
    case Kind::uint32:
      return put_integer<std::uint32_t>(member, value);
    case Kind::int64:
      return put_integer<std::int64_t>(member, value);
    case Kind::uint64:
      return put_integer<std::uint64_t>(member, value);
    default:
      return put_float(member, value);
  }
}

/// Puts an integer. Accepts all objects that Python converts to an integer, and the names of enumerators.
template <class Number>
void Encoder::put_integer(const Member& member, const py::handle& value) {
  using Limits = std::numeric_limits<Number>;
  const auto expected = [] {
    return "an integer from " + std::to_string(Limits::min()) + " to " + std::to_string(Limits::max());
  };
  if (member.enumeration != nullptr && PyUnicode_Check(value.ptr())) {
    const auto& all = member.enumeration->enumerators;
    const auto found = std::ranges::find(all, text_in(value), &EnumType::Enumerator::name);
    if (found == all.end())
      refuse(PyExc_ValueError, value, "a name of " + short_name(member.enumeration->name));
    return put_value(static_cast<Number>(found->value));
  }
  if (!PyIndex_Check(value.ptr())) refuse(PyExc_TypeError, value, expected());
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!index) {
    if (PyErr_ExceptionMatches(PyExc_TypeError) == 0) throw py::error_already_set();
    PyErr_Clear();
    refuse(PyExc_TypeError, value, expected());
  }
  using Wide = std::conditional_t<std::is_signed_v<Number>, long long, unsigned long long>;
  Wide wide = 0;
  if constexpr (std::is_signed_v<Number>) {
    wide = PyLong_AsLongLong(index.ptr());
  } else {
    wide = PyLong_AsUnsignedLongLong(index.ptr());
  }
  const bool is_out = PyErr_Occurred() != nullptr;
  PyErr_Clear();
  if (is_out || !std::in_range<Number>(wide)) refuse(PyExc_ValueError, value, expected());
  put_value(static_cast<Number>(wide));
}

void Encoder::put_float(const Member& member, const py::handle& value) {
  PyObject* const p = value.ptr();
  const bool is_text = PyUnicode_Check(p) || PyBytes_Check(p) || PyByteArray_Check(p);
  const bool is_numeric = !is_text && !PyComplex_Check(p) &&
                          (PyFloat_Check(p) || PyIndex_Check(p) || py::hasattr(value, "__float__"));
  if (!is_numeric) refuse(PyExc_TypeError, value, "a number");
  const double number = PyFloat_AsDouble(p);
  if (PyErr_Occurred() != nullptr) {
    const bool is_out = PyErr_ExceptionMatches(PyExc_OverflowError) != 0;
    if (!is_out && PyErr_ExceptionMatches(PyExc_TypeError) == 0) throw py::error_already_set();
    PyErr_Clear();
    refuse(is_out ? PyExc_ValueError : PyExc_TypeError, value, "a number of 64 bits");
  }
  if (member.kind == Kind::float64) return put_value(number);
  if (std::isfinite(number) && std::abs(number) > std::numeric_limits<float>::max())
    refuse(PyExc_ValueError, value, "a number of 32 bits");
  put_value(static_cast<float>(number));
}

// ---- arrays and sequences ----

void Encoder::put_length(const Member& member, std::size_t count) {
  const bool fits = member.shape == Shape::array ? count == member.count
                                                 : count <= (member.bound == 0 ? count_max : member.bound);
  if (!fits) refuse_count(member, count);
  if (member.shape == Shape::sequence) put_value(static_cast<std::uint32_t>(count));
}

void Encoder::put_numbers(const Member& member, const py::handle& value) {
  const std::size_t size = bytes_of(member.kind);
  if (!value) {
    const std::size_t count = member.shape == Shape::array ? member.count : 0;
    put_length(member, count);
    if (count > 0) plan_.align(size);
    if (makes_room_) plan_.note({path_, &member, plan_.bytes(), count});
    return plan_.put_zeros(count * size);
  }
  const py::dtype type(dtype_text(member.kind));
  py::object given = py::reinterpret_borrow<py::object>(value);
  const bool fits_already = py::isinstance<py::array>(given) && py::array(given).dtype().equal(type) &&
                            py::array(given).ndim() > 0 &&
                            (py::array(given).flags() & py::array::c_style) != 0;
  if (!fits_already) given = py::module_::import("sft._fit").attr("fit_array")(given, type, path_);
  const py::array numbers(given);
  const auto count = static_cast<std::size_t>(numbers.size());
  put_length(member, count);
  if (count > 0) plan_.align(size);
  if (makes_room_) plan_.note({path_, &member, plan_.bytes(), count});
  plan_.put_array(numbers.data(), count * size, numbers);
}

void Encoder::put_room(const Member& member, const py::handle& count) {
  const std::size_t wanted = PyLong_AsSize_t(count.ptr());
  if (PyErr_Occurred() != nullptr || wanted > count_max) {
    PyErr_Clear();
    refuse(PyExc_ValueError, count, "a number of elements");
  }
  put_length(member, wanted);
  if (wanted > 0) plan_.align(bytes_of(member.kind));
  plan_.note({path_, &member, plan_.bytes(), wanted});
  plan_.reserve(wanted * bytes_of(member.kind));
}

void Encoder::put_elements(const Member& member, const py::handle& value) {
  // No places are noted in lists, since their elements are not written later
  const bool notes = std::exchange(makes_room_, false);
  if (value && !is_list(value)) refuse(PyExc_TypeError, value, "a list");
  py::object list;
  if (value) list = py::reinterpret_steal<py::object>(PySequence_Tuple(value.ptr()));
  if (value && !list) throw py::error_already_set();
  const std::size_t given = list ? py::len(list) : 0;
  const std::size_t count = list || member.shape == Shape::sequence ? given : member.count;
  put_length(member, count);
  for (std::size_t i = 0; i < count; ++i) {
    const Step step(path_, i);
    put_single(member,
               list ? py::handle(PyTuple_GET_ITEM(list.ptr(), static_cast<py::ssize_t>(i))) : py::handle());
  }
  makes_room_ = notes;
}

}  // namespace sft::python
