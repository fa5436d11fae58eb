// The questions of this benchmark. Each runs our side and its references in turns and returns figures.
#pragma once

#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

/// From owned structs to CDR: everything, two scalars, small messages; against copying, Cyclone DDS, Fast
/// CDR.
std::vector<Figure> encoding(int rounds);
/// From CDR to what a reader sees: two scalars, everything; and checking and indexing what arrives.
std::vector<Figure> decoding(int rounds);
/// From one encoded sample to the payload of a smaller mask.
std::vector<Figure> gathering(int rounds);
/// What the IDL compiler writes, and what it costs to compile.
std::vector<Figure> generated_code();

}  // namespace sft::bench
