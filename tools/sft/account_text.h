// Formats the counters of both sides of a pair as text.
#pragma once

#include <sft/domain.h>
#include <string>

namespace sft::tool {

/// Returns true if both sides have reported their counters, or if the pair does not match and so has no
/// counters.
bool is_reported(const DomainSnapshot::Pair& pair);

/// Returns a text such as "the publisher's node does not answer", with possible causes. Returns an empty text
/// if both sides have reported their counters.
std::string unanswered_text(const DomainSnapshot::Pair& pair);

/// Returns true if both sides have reported their counters, samples were sent, and the subscriber has taken
/// none.
bool takes_none(const DomainSnapshot::Pair& pair);
/// Returns a text such as "120 samples were sent, and the subscriber has taken none", with possible causes.
/// Returns an empty text if the subscriber has taken any samples.
std::string takes_none_text(const DomainSnapshot::Pair& pair);

/// Returns a text that samples from a DDS writer arrived at the subscriber, which has taken none of them,
/// with possible causes. Returns an empty text for other pairs.
std::string unreadable_text(const DomainSnapshot::Pair& pair);

// If a side has not reported its counters, these functions return "not reported yet".

/// Returns a text such as "5 samples, 40 B over the network".
std::string sent_text(const DomainSnapshot::Pair& pair);
/// Returns a text such as "31.5 MB, 99.9998 % of the whole samples".
std::string saved_text(const DomainSnapshot::Pair& pair);
/// Returns a text such as "5 samples; 0 dropped".
std::string withheld_text(const DomainSnapshot::Pair& pair);
/// Describes the samples that were sent by UDP because shared memory could not take them, and says what to
/// do. Returns an empty text if there are none.
std::string diverted_text(const DomainSnapshot::Pair& pair);
/// Returns a text such as "0 samples; 5 received".
std::string lost_text(const DomainSnapshot::Pair& pair);

/// These functions return the headings of a table of pairs, and one row of this table. The table is 80
/// columns wide. `by` is the transport. Names that are too long are cut, and counters that were not
/// reported are shown as "-".
std::string account_headings();
std::string account_columns(const std::string& names, const std::string& by,
                            const DomainSnapshot::Pair& pair);

}  // namespace sft::tool
