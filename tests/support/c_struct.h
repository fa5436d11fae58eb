// Messages as the C structs that stock idlc generates, made from SFT's type tables. Members are in order and
// naturally aligned. Strings are `char*` or `char[bound + 1]`, and sequences are dds_sequence_t.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "sft/detail/type_table.h"
#include "tests/support/owned_value.h"

namespace sft::test {

struct CLayout {
  std::size_t size = 0;
  std::size_t alignment = 1;
};
CLayout c_layout(const StructType& type);

/// The C struct of an owned value. The C struct refers to the strings and blocks of the value, which must
/// outlive this object.
class CStruct {
 public:
  explicit CStruct(const OwnedValue& value);
  const void* get() const { return struct_; }

 private:
  std::byte* zeros(std::size_t bytes);
  void fill(const StructType& type, const std::byte* from, std::byte* to);
  void fill_elements(const StructType::Member& m, Elements from, std::byte* to);

  std::vector<std::unique_ptr<std::byte[]>> memory_;
  std::byte* struct_;
};

/// Copies a C struct into `value`, and returns `value`.
OwnedValue from_c_struct(const void* c_struct, OwnedValue value);

}  // namespace sft::test
