// Arrays of numpy over SFT's memory, and the types of their elements.
#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <vector>

#include "sft/type.h"

namespace sft::python {

namespace py = pybind11;
using Kind = StructType::Member::Kind;
using Shape = StructType::Member::Shape;

constexpr bool is_number(Kind kind) { return kind != Kind::string && kind != Kind::structure; }
/// Returns the name of the type in numpy, such as "<f4". `is_swapped` is true if the numbers do not have
/// the byte order of this host.
std::string dtype_text(Kind kind, bool is_swapped = false);
/// Returns the size of one number in bytes.
std::size_t bytes_of(Kind kind);

/// Returns a Python object that keeps `owner` alive, for use as the base of arrays.
template <class T>
py::capsule keep(std::shared_ptr<T> owner) {
  using Owner = std::shared_ptr<T>;
  auto* const kept = new Owner(std::move(owner));
  return py::capsule(kept, [](void* owned) { delete static_cast<Owner*>(owned); });
}

/// Returns an array over this memory, which `owner` keeps alive. A read-only array cannot be made writable,
/// because its owner offers no writable buffer.
py::array array_over(const void* data, const py::dtype& type, std::vector<py::ssize_t> shape,
                     std::vector<py::ssize_t> strides, const py::object& owner, bool is_writable = false);

}  // namespace sft::python
