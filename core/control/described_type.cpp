#include "core/control/described_type.h"

#include <string>

#include "sft/detail/type_description.h"

namespace sft::core {

namespace {
constexpr DynamicType::Limits limits{.bytes = type_description_bytes_max, .leaves = leaves_max};
}  // namespace

Result<std::vector<std::byte>> announced_description(const StructType& type) {
  std::vector<std::byte> description = detail::describe(type);
  return DynamicType::parse(description, limits).map([&](const DynamicType&) {
    return std::move(description);
  });
}

Result<DynamicType> described_type(const Endpoint& endpoint) {
  const std::string whose = "node '" + endpoint.node + "', topic '" + endpoint.topic + "': ";
  if (endpoint.type_description.empty()) {
    return fail(
        Errc::unavailable,
        whose + "the fields of " + endpoint.type_name +
            " are not known here: its description is not announced, because it is too large or too deep "
            "(docs/limits.md); open the topic with a type that is made of the definition ('sft ... -I "
            "DIRECTORY', find_msg())");
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
