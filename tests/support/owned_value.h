// Messages of any type, accessed through the type's table.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>

#include "sft/detail/type_table.h"

namespace sft::test {

/// An owned struct of any type. A new struct has the default values. Copies share the struct.
class OwnedValue {
 public:
  template <class T>
  static OwnedValue of() {
    return OwnedValue(detail::TypeTable<T>::type, std::make_shared<T>());
  }

  const StructType& type() const { return *type_; }
  void* get() { return value_.get(); }
  const void* get() const { return value_.get(); }

 private:
  OwnedValue(const StructType& type, std::shared_ptr<void> value) : type_(&type), value_(std::move(value)) {}

  const StructType* type_;
  std::shared_ptr<void> value_;
};

/// The elements of a member of an owned struct: of a single value, an array or a sequence.
struct Elements {
  const std::byte* first;
  std::size_t count;
};
Elements elements_of(const StructType::Member& member, const void* object);

/// Returns the first element for writing. If the member is a sequence, resizes it to `count` elements, and
/// keeps the elements that it has.
std::byte* resized(const StructType::Member& member, void* object, std::size_t count);

/// Compares all leaves bit by bit, so that a NaN equals itself. The failure message names the first leaf that
/// differs.
::testing::AssertionResult same_value(const StructType& type, const void* a, const void* b);
inline ::testing::AssertionResult same_value(const OwnedValue& a, const OwnedValue& b) {
  return same_value(a.type(), a.get(), b.get());
}

}  // namespace sft::test
