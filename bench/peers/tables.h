// Tables of results for people.
#pragma once

#include <string>
#include <vector>

#include "bench/peers/record.h"

namespace sft::bench::peers {

/// A column of a table: the records of one case and size.
struct Column {
  std::string label;
  Case of;
  std::uint32_t bytes = 0;
};

/// Returns a column for each size.
std::vector<Column> columns_of_sizes(const Case& of, const std::vector<std::uint32_t>& sizes);
/// Returns a column for each number of readers.
std::vector<Column> columns_of_readers(Case of, const std::vector<std::size_t>& readers, std::uint32_t bytes);

/// Returns a number as text with three significant digits, or all digits of its integer part: "5.31",
/// "42.5", "1,204". Returns "-" if the number is unknown.
std::string number_text(double value);

/// Returns tables with latency, throughput and processor time of all entrants that have records in these
/// columns.
std::string tables(const Records& all, const std::string& title, const std::vector<Column>& columns);

}  // namespace sft::bench::peers
