#include "tests/support/c_struct.h"

#include <dds/ddsc/dds_public_impl.h>

#include <algorithm>
#include <cstring>
#include <string>

namespace sft::test {

namespace {

using namespace detail;

/// In C all enumerations have the width of an int. In CDR and in the structs of SFT they are only as wide as
/// necessary.
bool is_c_enum(const Member& m) { return m.enumeration != nullptr && !m.enumeration->is_bitmask; }

/// Returns the layout of one element of the member.
CLayout element_layout(const Member& m) {
  if (m.kind == Kind::structure) return c_layout(*m.type);
  if (is_c_enum(m)) return {sizeof(std::int32_t), alignof(std::int32_t)};
  if (m.kind != Kind::string) return {size_of(m.kind), size_of(m.kind)};
  return m.string_bound == 0 ? CLayout{sizeof(char*), alignof(char*)}
                             : CLayout{m.string_bound + std::size_t{1}, 1};
}

CLayout member_layout(const Member& m) {
  if (m.shape == Shape::sequence) return {sizeof(dds_sequence_t), alignof(dds_sequence_t)};
  const CLayout element = element_layout(m);
  return {element.size * m.count, element.alignment};
}

std::size_t aligned(std::size_t offset, std::size_t alignment) {
  return (offset + alignment - 1) / alignment * alignment;
}

/// Calls visit(member, offset in the C struct) for each member. Returns the end of the last member, in bytes.
template <class Visit>
std::size_t for_each_c_member(const StructType& type, Visit visit) {
  std::size_t offset = 0;
  for (const Member& m : type.members) {
    const CLayout layout = member_layout(m);
    offset = aligned(offset, layout.alignment);
    visit(m, offset);
    offset += layout.size;
  }
  return offset;
}

void copy_structure(const StructType& type, const std::byte* from, std::byte* to);

void copy_element(const Member& m, const std::byte* from, std::byte* to) {
  if (m.kind == Kind::structure) {
    copy_structure(*m.type, from, to);
  } else if (m.kind != Kind::string) {
    // Copies only the lower bytes if `from` or `to` is a C enumeration.
    std::memcpy(to, from, size_of(m.kind));
  } else {
    const auto* text = reinterpret_cast<const char*>(from);
    if (m.string_bound == 0) std::memcpy(&text, from, sizeof text);
    *reinterpret_cast<std::string*>(to) = text;
  }
}

void copy_structure(const StructType& type, const std::byte* from, std::byte* to) {
  for_each_c_member(type, [&](const Member& m, std::size_t offset) {
    Elements source{from + offset, m.count};
    if (m.shape == Shape::sequence) {
      const auto* sequence = reinterpret_cast<const dds_sequence_t*>(from + offset);
      source = {reinterpret_cast<const std::byte*>(sequence->_buffer), sequence->_length};
    }
    std::byte* target = resized(m, to, source.count);
    const std::size_t c_stride = element_layout(m).size;
    for (std::size_t i = 0; i < source.count; ++i) {
      copy_element(m, source.first + i * c_stride, target + i * m.stride);
    }
  });
}

}  // namespace

CLayout c_layout(const StructType& type) {
  CLayout layout;
  layout.size = for_each_c_member(type, [&](const Member& m, std::size_t) {
    layout.alignment = std::max(layout.alignment, member_layout(m).alignment);
  });
  layout.size = aligned(layout.size, layout.alignment);
  return layout;
}

CStruct::CStruct(const OwnedValue& value) : struct_(zeros(c_layout(value.type()).size)) {
  fill(value.type(), static_cast<const std::byte*>(value.get()), struct_);
}

std::byte* CStruct::zeros(std::size_t bytes) {
  memory_.push_back(std::make_unique<std::byte[]>(bytes));
  return memory_.back().get();
}

void CStruct::fill(const StructType& type, const std::byte* from, std::byte* to) {
  for_each_c_member(type, [&](const Member& m, std::size_t offset) {
    const Elements source = elements_of(m, from);
    if (m.shape != Shape::sequence) return fill_elements(m, source, to + offset);
    auto* sequence = reinterpret_cast<dds_sequence_t*>(to + offset);
    sequence->_length = sequence->_maximum = static_cast<std::uint32_t>(source.count);
    if (source.count == 0) return;
    std::byte* elements = zeros(source.count * element_layout(m).size);
    sequence->_buffer = reinterpret_cast<std::uint8_t*>(elements);
    fill_elements(m, source, elements);
  });
}

void CStruct::fill_elements(const Member& m, Elements from, std::byte* to) {
  const std::size_t c_stride = element_layout(m).size;
  for (std::size_t i = 0; i < from.count; ++i) {
    const std::byte* source = from.first + i * m.stride;
    std::byte* target = to + i * c_stride;
    if (m.kind == Kind::structure) {
      fill(*m.type, source, target);
    } else if (m.kind != Kind::string) {
      std::memcpy(target, source, size_of(m.kind));
    } else {
      const char* text = reinterpret_cast<const std::string*>(source)->c_str();
      if (m.string_bound == 0) {
        std::memcpy(target, &text, sizeof text);
      } else {
        std::memcpy(target, text, std::strlen(text) + 1);
      }
    }
  }
}

OwnedValue from_c_struct(const void* c_struct, OwnedValue value) {
  copy_structure(value.type(), static_cast<const std::byte*>(c_struct), static_cast<std::byte*>(value.get()));
  return value;
}

}  // namespace sft::test
