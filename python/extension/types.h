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
  /// Returns the type for use with nodes. Throws if this is a nested struct.
  const DynamicType& whole() const;
  /// Returns the members, each as a tuple of name, kind, shape, count, bound, unit, and a PyType or None.
  py::list members() const;
  /// Returns a tuple that is equal for equal types: the name, and the description of the whole type.
  py::tuple key() const;
  /// Throws an exception if the member cannot have this value.
  void check(const std::string& member, const py::handle& value) const;
  /// Returns the message as CDR with its encapsulation.
  py::bytes encode(const py::handle& message) const;

 private:
  DynamicType root_;
  const StructType* type_;
};

/// Adds the class and the functions that make types to the module.
void define_types(py::module_& module);

}  // namespace sft::python
