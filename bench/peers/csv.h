// The records as comma-separated values: one line for each entrant, case, size and round.
#pragma once

#include <iosfwd>

#include "bench/peers/record.h"

namespace sft::bench::peers {

void write_csv(std::ostream& out, const Records& all);

}  // namespace sft::bench::peers
