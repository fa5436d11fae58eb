// Tables as text: the paper's results compared with those of this run.
#pragma once

#include <string>
#include <vector>

#include "bench/paper/comparison.h"
#include "bench/paper/rows.h"

namespace sft::bench::paper {

/// Returns a table with mean rates in kbit/s at the receivers for 10 messages per second, the saving of SFT
/// relative to the full message, and mean latencies.
std::string paper_table(const Records& all, const std::vector<Row>& rows);
/// Returns a text with the share of fields that receivers drew, and the number of receivers that drew none.
std::string draws_text(const Records& all);

}  // namespace sft::bench::paper
