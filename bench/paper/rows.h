// The rows of the paper's tables: the cases of each row, and the results of the paper.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/paper/comparison.h"

namespace sft::bench::paper {

/// The measurements of the paper, as means over the cases. Rates are for 10 messages per second.
struct Published {
  double fast_dds_kbit_s = 0, embedded_rtps_kbit_s = 0, sft_kbit_s = 0;
  double fast_dds_ms = 0, embedded_rtps_ms = 0, sft_ms = 0;
};

struct Row {
  std::string name;   ///< the name of the row's figure, as in JSON
  std::string title;  ///< the title of the row in tables
  Cases cases;
  /// The share of bytes that SFT saves in the paper, such as 0.491. Negative: SFT takes more bytes.
  std::optional<double> saving;
  double bound = 1;                      ///< the limit of SFT's bytes divided by the peers' bytes
  bool sends_all = false;                ///< true: each receiver needs all fields
  std::optional<Published> published{};  ///< the paper's measurements; empty if the paper has none
};

/// Returns the rows of the parametric study.
std::vector<Row> parametric_rows();
/// Returns the rows of Nav2, with messages that this benchmark makes and with recorded messages.
std::vector<Row> nav2_rows();
std::vector<Row> point_cloud_rows();

}  // namespace sft::bench::paper
