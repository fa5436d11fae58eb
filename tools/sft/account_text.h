// The counters of both sides of a pair, as text.
#pragma once

#include <sft/domain.h>
#include <string>

namespace sft::tool {

/// Returns true if both sides have reported their counters, or if the pair does not match and has none.
bool is_told(const DomainSnapshot::Pair& pair);

/// Returns true if both sides have reported their counters, samples were sent, and the subscriber has taken
/// none.
bool takes_none(const DomainSnapshot::Pair& pair);
/// Returns "120 samples were sent, and the subscriber has taken none", and what may be the cause. Returns an
/// empty text if the subscriber has taken some.
std::string takes_none_text(const DomainSnapshot::Pair& pair);

// For counters that a side has not reported, these functions return "not told yet".

/// For example "5 samples, 40 B over the network".
std::string sent_text(const DomainSnapshot::Pair& pair);
/// For example "31.5 MB, 99.9998 % of the whole samples".
std::string saved_text(const DomainSnapshot::Pair& pair);
/// For example "5 samples; 0 dropped".
std::string withheld_text(const DomainSnapshot::Pair& pair);
/// Returns which samples went by UDP because shared memory could not take them, and what to do; an empty text
/// if there are none.
std::string diverted_text(const DomainSnapshot::Pair& pair);
/// For example "0 samples; 5 received".
std::string lost_text(const DomainSnapshot::Pair& pair);

/// Return the headings of a table of pairs, and one of its rows, 80 columns wide. `by` is the transport.
/// Names that are too long are cut, and counters that were not reported are "-".
std::string account_headings();
std::string account_columns(const std::string& names, const std::string& by,
                            const DomainSnapshot::Pair& pair);

}  // namespace sft::tool
