#include "python/extension/arrays.h"

#include <algorithm>
#include <string>
#include <string_view>

namespace sft::python {

namespace {

/// The names of the kinds in numpy, in the order of the enumeration.
constexpr std::string_view names_in_numpy[] = {"b1", "u1", "S1", "i1", "u1", "i2", "u2",
                                               "i4", "u4", "i8", "u8", "f4", "f8"};

}  // namespace

std::string dtype_text(Kind kind, bool is_swapped) {
  return (is_swapped ? ">" : "<") + std::string(names_in_numpy[static_cast<std::size_t>(kind)]);
}

std::size_t bytes_of(Kind kind) {
  return static_cast<std::size_t>(names_in_numpy[static_cast<std::size_t>(kind)][1] - '0');
}

py::array array_over(const void* data, const py::dtype& type, std::vector<py::ssize_t> shape,
                     std::vector<py::ssize_t> strides, const py::object& owner, bool is_writable) {
  // An array without elements may have no memory.
  const bool is_empty = data == nullptr || std::ranges::find(shape, 0) != shape.end();
  py::array array =
      is_empty ? py::array(type, shape) : py::array(type, std::move(shape), std::move(strides), data, owner);
  if (!is_writable) py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

}  // namespace sft::python
