#include "tests/support/owned_value.h"

#include <cstring>
#include <string>

namespace sft::test {

namespace {

using namespace detail;

using ::testing::AssertionFailure;
using ::testing::AssertionResult;
using ::testing::AssertionSuccess;

AssertionResult same_element(const Member& m, const std::byte* a, const std::byte* b) {
  if (m.kind == Kind::structure) return same_value(*m.type, a, b);
  if (m.kind != Kind::string) {
    return std::memcmp(a, b, m.stride) == 0 ? AssertionSuccess() : AssertionFailure() << ": other bits";
  }
  const auto& text_a = *reinterpret_cast<const std::string*>(a);
  const auto& text_b = *reinterpret_cast<const std::string*>(b);
  return text_a == text_b ? AssertionSuccess()
                          : AssertionFailure() << ": '" << text_a << "' or '" << text_b << "'";
}

AssertionResult same_elements(const Member& m, Elements a, Elements b) {
  if (a.count != b.count) return AssertionFailure() << ": " << a.count << " or " << b.count << " elements";
  if (is_primitive(m.kind)) {  // compares all elements at once first, because most values are equal
    if (a.count == 0 || std::memcmp(a.first, b.first, a.count * m.stride) == 0) return AssertionSuccess();
  }
  for (std::size_t i = 0; i < a.count; ++i) {
    const AssertionResult same = same_element(m, a.first + i * m.stride, b.first + i * m.stride);
    if (!same) return AssertionFailure() << "[" << i << "]" << same.message();
  }
  return AssertionSuccess();
}

}  // namespace

Elements elements_of(const Member& member, const void* object) {
  const std::byte* at = static_cast<const std::byte*>(object) + member.offset;
  if (member.shape != Shape::sequence) return {at, member.count};
  return {static_cast<const std::byte*>(member.access->data(at)), member.access->size(at)};
}

std::byte* resized(const Member& member, void* object, std::size_t count) {
  std::byte* at = static_cast<std::byte*>(object) + member.offset;
  return member.shape == Shape::sequence ? static_cast<std::byte*>(member.access->resize(at, count)) : at;
}

AssertionResult same_value(const StructType& type, const void* a, const void* b) {
  for (const Member& m : type.members) {
    const AssertionResult same = same_elements(m, elements_of(m, a), elements_of(m, b));
    if (!same) return AssertionFailure() << "." << m.name << same.message();
  }
  return AssertionSuccess();
}

}  // namespace sft::test
