// The figures as text: a table while the demo runs, and what they mean at its end.
#pragma once

#include <string>
#include <vector>

#include "examples/demo/figures.h"
#include "examples/demo/protocol.h"

namespace sft::demo {

/// The table's lines: the head, a line per subscriber, and where needed a remark.
std::vector<std::string> format_table(const RunFigures& figures);

/// What this system refuses the publisher's host, so that the demo is slower than it could be: a line each.
std::vector<std::string> format_refusals(const PublisherReport& publisher);

/// One line for logs: "12.0 s: 120 published; received by diagnostic 120, ...; 0 lost".
std::string format_progress(const RunFigures& figures, double elapsed_s);

/// For people who have not read the code.
std::string format_summary(const RunFigures& figures);

}  // namespace sft::demo
