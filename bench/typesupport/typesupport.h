// The groups of this benchmark. Each runs SFT and its references in turns and returns figures.
#pragma once

#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

/// Measures the conversion from owned structs to CDR, for all fields, two scalars and small messages,
/// compared with copies and Cyclone DDS.
std::vector<Figure> encoding(int rounds);
/// Measures the conversion from CDR to the fields of a reader, for two scalars, and for all fields with the
/// check and index of an arriving sample.
std::vector<Figure> decoding(int rounds);
/// Measures the time to make the payload of a smaller mask from an encoded sample.
std::vector<Figure> gathering(int rounds);

}  // namespace sft::bench
