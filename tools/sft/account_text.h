// The counters of both sides of a pair, as text.
#pragma once

#include <sft/domain.h>
#include <string>

namespace sft::tool {

/// True if both sides have reported their counters, or if the pair does not match and has none.
bool is_told(const DomainSnapshot::Pair& pair);

// Counters that their side has not reported are "not told yet".

/// "5 samples, 40 B over the network"
std::string sent_text(const DomainSnapshot::Pair& pair);
/// "31.5 MB, 99.9998 % of the whole samples"
std::string saved_text(const DomainSnapshot::Pair& pair);
/// "5 samples; 0 dropped"
std::string withheld_text(const DomainSnapshot::Pair& pair);
/// Says which samples went by UDP because shared memory could not take them, and what to do; empty if none.
std::string diverted_text(const DomainSnapshot::Pair& pair);
/// "0 samples; 5 received"
std::string lost_text(const DomainSnapshot::Pair& pair);

/// One row of a table of pairs, 80 columns wide, and its headings. `by` is the transport. Names that are too
/// long are cut, and counters that were not reported are "-".
std::string account_headings();
std::string account_columns(const std::string& names, const std::string& by,
                            const DomainSnapshot::Pair& pair);

}  // namespace sft::tool
