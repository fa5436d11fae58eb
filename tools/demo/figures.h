// The figures of a run, computed from reports by pure arithmetic, as text and as JSON. No line has more than
// columns_max characters, unless a single word is longer. Table and summary together fit 24 lines.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/demo/reports.h"

namespace sft::demo {

/// One column stays free, since terminals differ in what they do after a character in the last one.
inline constexpr std::size_t columns_max = 79;

/// A subscriber: its reports, and what the publisher and the demo know of it.
struct SubscriberFigures : SubscriberReport {
  std::string name;
  double max_rate_hz = 0;  ///< 0: all samples
  bool recorded = false;   ///< its fields are recorded, not declared
  bool metered = false;    ///< its host is real, and so are its bytes on the wire
  Counts begin;            ///< just before the first sample
  std::uint64_t withheld = 0;
  std::uint64_t full_bytes = 0;  ///< encapsulation and body of the whole message

  bool in_shared_memory() const { return transport == "shm"; }
  /// Returns all bytes that were sent, learning included: on the wire if that was measured, else the payload.
  double bytes() const;
  /// Returns the bytes of a sample in the steady state: with recorded fields, after the mask had narrowed.
  /// Empty if no sample came since then.
  std::optional<double> bytes_per_sample() const;
  /// Returns the bytes on the wire until the recorded mask had narrowed; empty if not measured.
  std::optional<double> learning_bytes() const;
  /// Returns the share of the bytes of all whole messages that was not sent to the subscriber.
  double saved() const;
  /// Called when no sample can arrive any more: a subscriber does not know about samples after the last one
  /// that it received.
  void count_missing_as_lost(std::uint64_t published);
};

struct RunFigures {
  double hz = 0;
  std::uint64_t samples = 0;
  unsigned hosts = 0;
  std::vector<SubscriberFigures> subscribers;

  bool real_hosts() const { return hosts > 1; }
  std::uint64_t lost() const;
  // Sums over all subscribers that are not served in shared memory.
  double carried_bytes() const;  ///< bytes that were sent
  double whole_bytes() const;    ///< bytes of all whole messages to all of them
};

nlohmann::ordered_json to_json(const RunFigures& run);

/// Returns "header, width", "all", or "header, 1 Hz".
std::string format_request(const SubscriberFigures& subscriber);

/// Returns the lines of the table: the head, and a line per subscriber.
std::vector<std::string> format_table(const RunFigures& run);

/// Returns one line: "12.0 s: 120 published; the network carried 78.61 MB, not 3.02 GB; 0 lost".
std::string format_progress(const RunFigures& run, double elapsed_s);

/// Returns lines for users that have not read the code. The first line has the result.
std::vector<std::string> format_summary(const RunFigures& run);

/// Returns one line for each service that would make the demo faster, and that this system refuses to the
/// publisher's host.
std::vector<std::string> format_refusals(const PublisherReport& publisher);

}  // namespace sft::demo
