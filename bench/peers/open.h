// The contenders of bench/common that entrants are.
#pragma once

#include "bench/common/contender.h"
#include "bench/peers/entrant.h"

namespace sft::bench::peers {

/// REQUIRES: the way has readers.
Contender contender_of(Way way, Where where);

/// A topic for messages of one size. Delivery is reliable. `name` outlives the topic.
Topic topic_of(const char* name, std::size_t number, std::uint32_t bytes, const Case& of,
               const Entrant& entrant);

}  // namespace sft::bench::peers
