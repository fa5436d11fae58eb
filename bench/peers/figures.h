// The figures of SFT compared with those of the fastest peer, for --json and ./run bench all.
#pragma once

#include <string>
#include <vector>

#include "bench/common/report.h"
#include "bench/peers/tables.h"

namespace sft::bench::peers {

/// Returns the p50, its processor time and the throughput of each entrant of SFT in each column. Each is
/// compared with the best peer in this respect. memcpy is not a peer. The name of a figure consists of the
/// group, the number of readers, the size, the entrant and the measure: "intra_readers_8_16B_sft_full_p50".
std::vector<Figure> figures(const std::string& group, const Records& all, const std::vector<Column>& columns);

}  // namespace sft::bench::peers
