// Finds topics and their types in a table of endpoints. Pure functions.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/negotiation/endpoint_table.h"
#include "sft/domain.h"
#include "sft/dynamic_type.h"
#include "sft/result.h"

namespace sft::core {

/// Returns the topics, ordered by name.
std::vector<TopicInfo> topics_of(const std::vector<TableEntry>& entries);

/// Returns the type that the publishers of a topic have announced, or, if there are none, its subscribers.
/// Returns Errc::unavailable if the type is not known (yet); the error names the announcements in that
/// domain. Returns Errc::type_mismatch if there are several definitions.
Result<DynamicType> type_of(std::string_view topic, const std::vector<const TableEntry*>& entries,
                            std::uint32_t domain);

}  // namespace sft::core
