#include "core/control/described_type.h"

#include <string>

#include "sft/detail/type_description.h"

namespace sft::core {

namespace {
constexpr DynamicType::Limits limits{.bytes = type_description_bytes_max, .leaves = leaves_max};
}  // namespace

std::vector<std::byte> announced_description(const StructType& type) {
  std::vector<std::byte> description = detail::describe(type);
  if (!DynamicType::parse(description, limits)) description.clear();
  return description;
}

Result<DynamicType> described_type(const Endpoint& endpoint) {
  const std::string whose = "node '" + endpoint.node + "', topic '" + endpoint.topic + "': ";
  if (endpoint.type_description.empty()) {
    return fail(Errc::unavailable,
                whose + "the description of " + endpoint.type_name + " is too large to be announced");
  }
  Result<DynamicType> type = DynamicType::parse(endpoint.type_description, limits);
  if (!type) return fail(type.error().code, whose + type.error().message);
  if (type->name() != endpoint.type_name || type->hash() != endpoint.type_hash) {
    return fail(Errc::malformed,
                whose + "the type description does not describe the announced type " + endpoint.type_name);
  }
  return type;
}

}  // namespace sft::core
