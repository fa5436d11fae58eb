// Message types in Python.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <utility>

#include "sft/dynamic_type.h"

namespace sft::python {

namespace py = pybind11;

/// A message type, or a struct that is nested in one.
class PyType {
 public:
  explicit PyType(DynamicType root) : PyType(root, root.type()) {}
  PyType(DynamicType root, const StructType& type) : root_(std::move(root)), type_(&type) {}

  std::string name() const;
  /// The type for nodes. Throws if this is a nested struct.
  const DynamicType& whole() const;
  /// The members, each as a tuple: name, kind, shape, count, bound, unit, PyType or None.
  py::list members() const;
  /// Equal for equal types: the name, and the description of the whole type.
  py::tuple key() const;
  /// Throws if the member cannot have this value.
  void check(const std::string& member, const py::handle& value) const;
  /// Returns the message as CDR with its encapsulation.
  py::bytes encode(const py::handle& message) const;

 private:
  DynamicType root_;
  const StructType* type_;
};

/// Adds the class and its makers to the module.
void define_types(py::module_& module);

}  // namespace sft::python
