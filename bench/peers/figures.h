// The figures of SFT beside those of the fastest peer, for --json and ./run bench all.
#pragma once

#include <string>
#include <vector>

#include "bench/common/report.h"
#include "bench/peers/tables.h"

namespace sft::bench::peers {

/// The p50, its processor time and the throughput of each entrant of SFT in each column, beside the best peer
/// in each of them. memcpy is no peer.
std::vector<Figure> figures(const Records& all, const std::vector<Column>& columns);

}  // namespace sft::bench::peers
