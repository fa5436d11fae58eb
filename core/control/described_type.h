// Encodes the type descriptions that are announced with our endpoints, and decodes those of other
// processes' endpoints.
#pragma once

#include <cstddef>
#include <vector>

#include "core/control/control.h"
#include "sft/dynamic_type.h"
#include "sft/result.h"

namespace sft::core {

/// Returns the description of a type. If the type is too large for a description (DynamicType::Limits,
/// type_description_bytes_max), the result is an error that names the limit. Such a type is announced without
/// a description, and works only between programs that were compiled with it.
Result<std::vector<std::byte>> announced_description(const StructType& type);

/// Returns the type that an endpoint describes. Returns an error if the endpoint has no description, or if
/// the name or hash of the described type is not the announced one.
Result<DynamicType> described_type(const Endpoint& endpoint);

}  // namespace sft::core
