// The figures as text: a table while the demo runs, and what they mean at its end.
#pragma once

#include <string>
#include <vector>

#include "examples/demo/figures.h"

namespace sft::demo {

/// The table's lines: the head, a line per subscriber, and where needed a remark.
std::vector<std::string> format_table(const RunFigures& figures);

/// One line for logs: "12.0 s: 120 published; received by diagnostic 120, ...; 0 lost".
std::string format_progress(const RunFigures& figures, double elapsed_s);

/// For people who have not read the code.
std::string format_summary(const RunFigures& figures);

}  // namespace sft::demo
