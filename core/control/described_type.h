// The type descriptions that are announced with endpoints: encoding of our own, decoding of those of others.
#pragma once

#include <cstddef>
#include <vector>

#include "core/control/control.h"
#include "sft/dynamic_type.h"
#include "sft/result.h"

namespace sft::core {

/// Returns the description of a type. Returns an error, which names the limit, if the type is too large for
/// one (DynamicType::Limits, type_description_bytes_max). It is then announced without a description, and
/// still works between programs that were compiled with it.
Result<std::vector<std::byte>> announced_description(const StructType& type);

/// Returns the type that an endpoint describes. Returns an error if it describes none, or if the name or hash
/// of that type is not the announced one.
Result<DynamicType> described_type(const Endpoint& endpoint);

}  // namespace sft::core
