// Prints, as JSON, the properties of the types in types.inc: structure, paths, units, defaults and constants.
// The program is built with three sets of headers: made from .msg files, from rosidl's IDL, and from the IDL
// that SFT makes of messages.
#include "types.inc"

#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "sft/type_support.h"

namespace {

using nlohmann::json;

template <class T>
json number(const std::byte* at) {
  return *reinterpret_cast<const T*>(at);
}

json initial(const sft::StructType& type, const std::byte* object);

json element(const sft::StructType::Member& member, const std::byte* at) {
  switch (member.kind) {
    case sft::detail::Kind::boolean:
      return *at != std::byte{0};
    case sft::detail::Kind::octet:
    case sft::detail::Kind::uint8:
      return number<std::uint8_t>(at);
    case sft::detail::Kind::character:
    case sft::detail::Kind::int8:
      return number<std::int8_t>(at);
    case sft::detail::Kind::int16:
      return number<std::int16_t>(at);
    case sft::detail::Kind::uint16:
      return number<std::uint16_t>(at);
    case sft::detail::Kind::int32:
      return number<std::int32_t>(at);
    case sft::detail::Kind::uint32:
      return number<std::uint32_t>(at);
    case sft::detail::Kind::int64:
      return number<std::int64_t>(at);
    case sft::detail::Kind::uint64:
      return number<std::uint64_t>(at);
    case sft::detail::Kind::float32:
      return number<float>(at);
    case sft::detail::Kind::float64:
      return number<double>(at);
    case sft::detail::Kind::string:
      return number<std::string>(at);
    case sft::detail::Kind::structure:
      return initial(*member.type, at);
  }
  return {};
}

json value(const sft::StructType::Member& member, const std::byte* at) {
  if (member.shape == sft::detail::Shape::single) return element(member, at);
  const bool is_sequence = member.shape == sft::detail::Shape::sequence;
  const std::size_t count = is_sequence ? member.access->size(at) : member.count;
  const auto* first = is_sequence ? static_cast<const std::byte*>(member.access->data(at)) : at;
  json elements = json::array();
  for (std::size_t i = 0; i < count; ++i) elements.push_back(element(member, first + i * member.stride));
  return elements;
}

json initial(const sft::StructType& type, const std::byte* object) {
  json members = json::object();
  for (const sft::StructType::Member& m : type.members)
    members[std::string(m.name)] = value(m, object + m.offset);
  return members;
}

template <class T>
void describe(json& types) {
  const sft::TypeSupport support(sft::detail::TypeTable<T>::type);
  json& type = types[std::string(support.name())];
  type["hash"] = support.hash();
  for (std::size_t i = 0; i < support.leaves(); ++i) type["paths"].push_back(support.path(i));
  for (const sft::StructType::Member& m : support.type().members) type["units"][std::string(m.name)] = m.unit;
  const T object{};
  type["initial"] = initial(support.type(), reinterpret_cast<const std::byte*>(&object));
  type["constants"] = json::object();
}

template <class T, class V>
void constant(json& types, const char* name, const V& constant_value) {
  types[std::string(sft::detail::TypeTable<T>::type.name)]["constants"][name] = constant_value;
}

}  // namespace

int main() {
  json types;
  SFT_DESCRIBE_ALL(types)
  std::cout << types.dump(1) << '\n';
}
