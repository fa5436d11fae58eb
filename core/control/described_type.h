// Type descriptions as they travel with endpoints: what we announce, and what others did.
#pragma once

#include <cstddef>
#include <vector>

#include "core/control/control.h"
#include "sft/dynamic_type.h"
#include "sft/result.h"

namespace sft::core {

/// An error, which names the limit, for a type that is beyond what a description may be (DynamicType::Limits,
/// type_description_bytes_max). It is announced without one, and works all the same between programs that
/// were compiled with it.
Result<std::vector<std::byte>> announced_description(const StructType& type);

/// The type that an endpoint describes. An error if it describes none, or one of another name or hash than it
/// announces.
Result<DynamicType> described_type(const Endpoint& endpoint);

}  // namespace sft::core
