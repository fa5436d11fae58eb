// Tables for people: the paper's results compared with those of this run.
#pragma once

#include <string>
#include <vector>

#include "bench/paper/comparison.h"
#include "bench/paper/rows.h"

namespace sft::bench::paper {

/// Returns mean rates in kbit/s at the receivers for 10 messages per second, how much less than the full
/// message SFT takes, and mean latencies.
std::string paper_table(const Records& all, const std::vector<Row>& rows);
/// Returns bytes per message and traffic without messages of each contender, at the receivers and at the
/// sender.
std::string bytes_table(const Records& all, const std::vector<Row>& rows);
/// Returns the bytes at each receiver of a case, compared with the fewest possible.
std::string receivers_table(const Records& all, const Row& row);
/// Returns the share of fields that receivers drew, and how many receivers drew none.
std::string draws_text(const Records& all);

}  // namespace sft::bench::paper
