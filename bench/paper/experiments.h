// The paper's experiments: the messages, their receivers, and the fields that each receiver reads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "bench/paper/record.h"
#include "bench/paper/schedule.h"
#include "bench/paper/session.h"

namespace sft::bench::paper {

struct Scale {
  Pace pace{};
  std::size_t repeats = 5;                ///< the number of repeats of each case
  std::vector<std::size_t> fields{5, 7};  ///< the numbers of fields of a message in the parametric study
  std::vector<std::size_t> field_bytes{128, 256, 512};
  std::uint64_t seed = 1;        ///< determines the receivers' fields and the order of contenders
  std::filesystem::path data{};  ///< the directory with recorded messages
};

// The following functions add the records of all repeats to `results`.
void run_parametric_study(const Stage& stage, const Scale& scale, Results& results);
/// Runs the cases of Nav2, with messages that this benchmark makes and with recorded messages.
void run_nav2_cases(const Stage& stage, const Scale& scale, Results& results);
/// Runs the case of the PointCloud2, with messages that this benchmark makes and with recorded messages.
void run_point_cloud_case(const Stage& stage, const Scale& scale, Results& results);

}  // namespace sft::bench::paper
