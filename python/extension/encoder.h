// Encodes messages of Python as CDR. A struct is given as a mapping, as an object with attributes, or as an
// sft.Message. Members that are missing in a mapping become zero or empty. A value that does not fit its
// field raises a TypeError or a ValueError, which names the path of the field, the value, and the expected
// type or range. Values are never truncated.
#pragma once

#include <pybind11/pybind11.h>

#include <optional>
#include <string>

#include "python/extension/plan.h"
#include "sft/type.h"

namespace sft::python {

/// Encodes one message. REQUIRES: the calling thread has the GIL.
class Encoder {
 public:
  /// If `makes_room` is true, the message is a loan. Then an integer in place of a sequence of numbers
  /// reserves this number of elements, and the places of fields are noted.
  explicit Encoder(bool makes_room = false) : makes_room_(makes_room) {}

  /// Encodes a whole message.
  Plan message(const StructType& type, const py::handle& value);
  /// Encodes one member. Errors name the member `path`.
  Plan member(const StructType::Member& member, const py::handle& value, const std::string& path);

 private:
  using Member = StructType::Member;
  class Step;

  // In the following functions, a null handle means that no value is given.
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
