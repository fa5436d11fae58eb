// The figures as text: a table while the demo runs, and their meaning at its end. No line has more than
// columns_max characters, unless a single word is longer. Table and summary together fit 24 lines.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/demo/roles/protocol.h"
#include "tools/demo/screen/figures.h"

namespace sft::demo {

/// One column stays free, since terminals differ in what they do after a character in the last one.
inline constexpr std::size_t columns_max = 79;

/// Returns the lines of the table: the head, and a line per subscriber.
std::vector<std::string> format_table(const RunFigures& figures);

/// Returns one line for each service that would make the demo faster, and that this system refuses to the
/// publisher's host.
std::vector<std::string> format_refusals(const PublisherReport& publisher);

/// Returns one line: "12.0 s: 120 published; the network carried 78.61 MB, not 3.02 GB; 0 lost".
std::string format_progress(const RunFigures& figures, double elapsed_s);

/// Returns lines for people who have not read the code. The first line has the result.
std::vector<std::string> format_summary(const RunFigures& figures);

}  // namespace sft::demo
