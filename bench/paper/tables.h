// Tables for people: the paper's results beside those of this run.
#pragma once

#include <string>
#include <vector>

#include "bench/paper/comparison.h"
#include "bench/paper/rows.h"

namespace sft::bench::paper {

/// Mean rates in kbit/s at 10 messages a second, at the receivers, and how much less than the full message
/// SFT takes; mean latencies.
std::string paper_table(const Records& all, const std::vector<Row>& rows);
/// Bytes of a message and traffic without messages, of each contender: at the receivers and at the sender.
std::string bytes_table(const Records& all, const std::vector<Row>& rows);
/// Bytes at each receiver of a case beside the fewest that can be.
std::string receivers_table(const Records& all, const Row& row);
/// The share of fields that receivers drew, and how many drew none.
std::string draws_text(const Records& all);

}  // namespace sft::bench::paper
