#include "core/vanilla/type_hash.h"

#include <openssl/sha.h>

#include <array>
#include <map>
#include <string_view>

#include "core/vanilla/dds_names.h"
#include "sft/domain.h"

namespace sft::core {

namespace {

using Member = StructType::Member;

// Numbers from type_description_interfaces/msg/FieldType.
constexpr int array_offset = 48, bounded_sequence_offset = 96, sequence_offset = 144;

int number_of(const Member& member) {
  switch (member.kind) {
    case Member::Kind::structure:
      return 1;
    case Member::Kind::int8:
      return 2;
    case Member::Kind::uint8:
      return 3;
    case Member::Kind::int16:
      return 4;
    case Member::Kind::uint16:
      return 5;
    case Member::Kind::int32:
      return 6;
    case Member::Kind::uint32:
      return 7;
    case Member::Kind::int64:
      return 8;
    case Member::Kind::uint64:
      return 9;
    case Member::Kind::float32:
      return 10;
    case Member::Kind::float64:
      return 11;
    case Member::Kind::character:
      return 13;
    case Member::Kind::boolean:
      return 15;
    case Member::Kind::octet:
      return 16;
    case Member::Kind::string:
      return member.string_bound == 0 ? 17 : 21;
  }
  return 0;
}

int offset_of(const Member& member) {
  if (member.shape == Member::Shape::single) return 0;
  if (member.shape == Member::Shape::array) return array_offset;
  return member.bound == 0 ? sequence_offset : bounded_sequence_offset;
}

/// Names of types and members are identifiers, which need no escapes.
std::string text_of(const Member& member) {
  const bool is_array = member.shape == Member::Shape::array;
  const std::uint32_t capacity = is_array ? member.count : member.bound;
  return R"({"name": ")" + std::string(member.name) + R"(", "type": {"type_id": )" +
         std::to_string(number_of(member) + offset_of(member)) + R"(, "capacity": )" +
         std::to_string(capacity) + R"(, "string_capacity": )" + std::to_string(member.string_bound) +
         R"(, "nested_type_name": ")" + (member.type == nullptr ? "" : ros_type_name(member.type->name)) +
         R"("}})";
}

/// Writes the descriptions of nested types in the order of their names, each description once.
class Descriptions {
 public:
  /// Adds the types that are nested in `type`. Returns false if ROS 2 has no such type.
  bool add_nested_in(const StructType& type) {
    for (const Member& member : type.members) {
      if (member.enumeration != nullptr || member.key) return false;
      if (member.type == nullptr) continue;
      const auto [entry, is_new] = texts_.try_emplace(ros_type_name(member.type->name));
      if (!is_new) continue;
      if (!add_nested_in(*member.type)) return false;
      entry->second = text_of_type(*member.type);
    }
    return true;
  }
  static std::string text_of_type(const StructType& type) {
    std::string text = R"({"type_name": ")" + ros_type_name(type.name) + R"(", "fields": [)";
    for (const Member& member : type.members)
      text += (&member == type.members.data() ? "" : ", ") + text_of(member);
    return text + "]}";
  }
  std::string text() const {
    std::string all;
    for (const auto& [name, text] : texts_) all += (all.empty() ? "" : ", ") + text;
    return all;
  }

 private:
  std::map<std::string, std::string> texts_;
};

/// Returns the hash in hexadecimal digits.
std::string sha256_of(std::string_view text) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data());
  std::string digits;
  for (const unsigned char octet : digest) {
    digits += "0123456789abcdef"[octet >> 4];
    digits += "0123456789abcdef"[octet & 15];
  }
  return digits;
}

}  // namespace

std::optional<std::string> ros_type_hash(const StructType& type) {
  Descriptions nested;
  if (!nested.add_nested_in(type)) return std::nullopt;
  const std::string text = R"({"type_description": )" + Descriptions::text_of_type(type) +
                           R"(, "referenced_type_descriptions": [)" + nested.text() + "]}";
  return "RIHS01_" + sha256_of(text);
}

}  // namespace sft::core

namespace sft {

std::optional<std::string> ros_type_hash(const DynamicType& type) { return core::ros_type_hash(type.type()); }

}  // namespace sft
