// The records as comma-separated values: one line for each contender, case and repeat.
#pragma once

#include <iosfwd>

#include "bench/paper/comparison.h"

namespace sft::bench::paper {

void write_csv(std::ostream& out, const Records& all);

}  // namespace sft::bench::paper
