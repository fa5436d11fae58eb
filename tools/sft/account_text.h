// What both sides of a pair have counted, as text.
#pragma once

#include <sft/domain.h>
#include <string>

namespace sft::tool {

/// Whether all that can be known of the pair has been told.
bool is_told(const PairInfo& pair);

// What its side did not tell is "not told yet".

/// "5 samples, 40 B over the network"
std::string sent_text(const PairInfo& pair);
/// "31.5 MB, 99.9998 % of the whole samples"
std::string saved_text(const PairInfo& pair);
/// "5 samples; 0 dropped"
std::string withheld_text(const PairInfo& pair);
/// "0 samples; 5 received"
std::string lost_text(const PairInfo& pair);

/// The same in columns, and the headings of these. What was not told is "-". 80 columns wide in all: `names`
/// and `by`, the transport, are cut if they are too long.
std::string account_headings();
std::string account_columns(const std::string& names, const std::string& by, const PairInfo& pair);

}  // namespace sft::tool
