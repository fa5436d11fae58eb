// The figures of this benchmark, with the bounds that SFT must keep.
#pragma once

#include <vector>

#include "bench/common/report.h"
#include "bench/paper/comparison.h"
#include "bench/paper/rows.h"

namespace sft::bench::paper {

/// Returns the bytes and the latencies of each row that has records.
std::vector<Figure> row_figures(const Records& all, const std::vector<Row>& rows);

/// Returns the figures that have a bound in every configuration: bytes relative to the fewest possible, and
/// latencies.
std::vector<Figure> configuration_figures(const Records& all);

/// Returns the costs of selecting fields relative to sending all fields: processor time and memory of the
/// parametric study.
std::vector<Figure> overhead_figures(const Records& all);

}  // namespace sft::bench::paper
