// Tables for people.
#pragma once

#include <string>
#include <vector>

#include "bench/peers/record.h"

namespace sft::bench::peers {

/// The records of one case and size.
struct Column {
  std::string label;
  Case of;
  std::uint32_t bytes = 0;
};

/// A column for each size.
std::vector<Column> columns_of_sizes(const Case& of, const std::vector<std::uint32_t>& sizes);
/// A column for each number of readers.
std::vector<Column> columns_of_readers(Case of, const std::vector<std::size_t>& readers, std::uint32_t bytes);

/// "5.31", "42.5", "1,204": three digits that count, or all of a whole number. "-" if it is unknown.
std::string number_text(double value);

/// Latency, throughput and processor time of all entrants that have records in these columns.
std::string tables(const Records& all, const std::string& title, const std::vector<Column>& columns);

}  // namespace sft::bench::peers
