// The rows of the paper's results: which cases they are about, and what the paper found.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/paper/comparison.h"

namespace sft::bench::paper {

/// What the paper measured, as a mean over the cases. The rates are those at 10 messages a second.
struct Published {
  double fast_dds_kbit_s = 0, embedded_rtps_kbit_s = 0, sft_kbit_s = 0;
  double fast_dds_ms = 0, embedded_rtps_ms = 0, sft_ms = 0;
};

struct Row {
  std::string name;   ///< of the figure
  std::string title;  ///< the title of the figure in tables
  Cases cases;
  std::optional<double> saving;          ///< of SFT's bytes in the paper: 0.491; negative: SFT takes more
  double bound = 1;                      ///< for SFT's bytes divided by the peers'
  bool sends_all = false;                ///< each receiver needs all fields
  std::optional<Published> published{};  ///< if the paper has the figures themselves
};

/// The rows of the parametric study.
std::vector<Row> parametric_rows();
/// The rows of Nav2, with messages of this benchmark and with recorded ones.
std::vector<Row> nav2_rows();
std::vector<Row> point_cloud_rows();

}  // namespace sft::bench::paper
