// Messages of Python as CDR. A struct is a mapping, an object with attributes, or an sft.Message; the members
// that a mapping lacks are zero or empty. What does not fit raises a TypeError or a ValueError that names the
// path of the field, the value, and what was expected. Nothing is cut.
#pragma once

#include <pybind11/pybind11.h>

#include <optional>
#include <string>

#include "python/extension/plan.h"
#include "sft/type.h"

namespace sft::python {

/// For one message. REQUIRES: the calling thread has the GIL.
class Encoder {
 public:
  /// `makes_room`: the message is a loan: an integer in place of a sequence of numbers leaves room for that
  /// many, and the places of fields are noted.
  explicit Encoder(bool makes_room = false) : makes_room_(makes_room) {}

  /// Encodes a whole message.
  Plan message(const StructType& type, const py::handle& value);
  /// Encodes one member, which errors call `path`.
  Plan member(const StructType::Member& member, const py::handle& value, const std::string& path);

 private:
  using Member = StructType::Member;
  class Step;

  // A null handle stands for a value that is not given.
  void put_struct(const StructType& type, const py::handle& value);
  void put_mapping(const StructType& type, const py::dict& values);
  void put_member(const Member& member, const py::handle& value);
  void put_single(const Member& member, const py::handle& value);
  void put_number(const Member& member, const py::handle& value);
  void put_text(const Member& member, const py::handle& value);
  void put_numbers(const Member& member, const py::handle& value);
  void put_elements(const Member& member, const py::handle& value);
  void put_room(const Member& member, const py::handle& count);
  bool put_word(const StructType& type, const py::handle& value);
  void put_length(const Member& member, std::size_t count);
  template <class Number>
  void put_value(Number number);
  template <class Number>
  void put_integer(const Member& member, const py::handle& value);
  void put_float(const Member& member, const py::handle& value);
  [[noreturn]] void refuse(PyObject* exception, const py::handle& value, const std::string& expected) const;
  [[noreturn]] void refuse_count(const Member& member, std::size_t count) const;

  Plan plan_;
  std::string path_;
  bool makes_room_;
};

}  // namespace sft::python
