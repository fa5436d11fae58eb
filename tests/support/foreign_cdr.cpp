#include "tests/support/foreign_cdr.h"

#include <algorithm>
#include <array>
#include <ostream>
#include <string>

namespace sft::test {

namespace {

using namespace detail;

class Writer {
 public:
  explicit Writer(const ForeignEncoding& encoding) : encoding_(encoding) {}

  void structure(const StructType& type, const void* object) {
    for (const Member& m : type.members) {
      const bool is_primitive_type = is_primitive(m.kind) && m.enumeration == nullptr;
      if (encoding_.is_xcdr2 && m.shape != Shape::single && !is_primitive_type) {
        delimited(m, object);
      } else {
        member(m, object);
      }
    }
  }

  std::vector<std::byte> bytes;

 private:
  /// Writes a member preceded by its length. The length is filled in after the member was written.
  void delimited(const Member& m, const void* object) {
    number(0, 4);
    const std::size_t begin = bytes.size();
    member(m, object);
    const std::size_t length = bytes.size() - begin;
    for (std::size_t i = 0; i < 4; ++i) bytes[begin - 4 + i] = byte_of(length, 4, i);
  }

  void member(const Member& m, const void* object) {
    const Elements elements = elements_of(m, object);
    if (m.shape == Shape::sequence) number(elements.count, 4);
    for (std::size_t i = 0; i < elements.count; ++i) element(m, elements.first + i * m.stride);
  }

  void element(const Member& m, const std::byte* value) {
    if (m.kind == Kind::structure) {
      structure(*m.type, value);
    } else if (m.kind == Kind::string) {
      const auto& text = *reinterpret_cast<const std::string*>(value);
      number(text.size() + 1, 4);
      for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
      bytes.push_back(std::byte{0});
    } else {
      std::uint64_t number_value = 0;
      for (std::size_t i = 0; i < size_of(m.kind); ++i)
        number_value |= std::to_integer<std::uint64_t>(value[i]) << (8 * i);
      number(number_value, size_of(m.kind));
    }
  }

  void number(std::uint64_t value, std::size_t size) {
    const std::size_t alignment = encoding_.is_xcdr2 ? std::min<std::size_t>(size, 4) : size;
    while (bytes.size() % alignment != 0) bytes.push_back(std::byte{0});
    for (std::size_t i = 0; i < size; ++i) bytes.push_back(byte_of(value, size, i));
  }

  std::byte byte_of(std::uint64_t value, std::size_t size, std::size_t i) const {
    const std::size_t place = encoding_.byte_order == std::endian::little ? i : size - 1 - i;
    return static_cast<std::byte>(value >> (8 * place));
  }

  const ForeignEncoding& encoding_;
};

}  // namespace

std::span<const ForeignEncoding> foreign_encodings() {
  static constexpr std::array encodings{
      cdr_le,
      cdr_be,
      cdr2_le,
      cdr2_be,
      ForeignEncoding{"CDR2_LE_of_table_39", 0x0011, std::endian::little, true},
      ForeignEncoding{"CDR2_BE_of_table_39", 0x0010, std::endian::big, true}};
  return encodings;
}

void PrintTo(const ForeignEncoding& encoding, std::ostream* out) { *out << encoding.name; }

std::vector<std::byte> foreign_cdr(const OwnedValue& value, const ForeignEncoding& encoding) {
  Writer writer(encoding);
  writer.structure(value.type(), value.get());
  return std::move(writer.bytes);
}

std::vector<std::byte> foreign_payload(std::span<const std::byte> body, const ForeignEncoding& encoding) {
  const std::size_t padding = (4 - body.size() % 4) % 4;
  std::vector<std::byte> payload(4 + body.size() + padding, std::byte{0xee});
  payload[0] = static_cast<std::byte>(encoding.code >> 8);
  payload[1] = static_cast<std::byte>(encoding.code);
  payload[2] = std::byte{0};
  payload[3] = static_cast<std::byte>(padding);
  std::copy(body.begin(), body.end(), payload.begin() + 4);
  return payload;
}

}  // namespace sft::test
