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

/// The maximum width of a line. The last column of a terminal is not used, since terminals differ in what
/// they do after a character there.
inline constexpr std::size_t columns_max = 79;

/// The reports of a subscriber, and the figures that the publisher and the demo have about it.
struct SubscriberFigures : SubscriberReport {
  std::string name;
  double max_rate_hz = 0;  ///< the maximum rate; 0: all samples
  bool recorded = false;   ///< true: the fields are recorded; false: they are declared
  bool metered = false;    ///< true: its host is a namespace, so that bytes on the wire are measured
  Counts begin;            ///< the counts just before the first sample
  std::uint64_t withheld = 0;
  std::uint64_t full_bytes = 0;  ///< encapsulation and body of the whole message

  bool in_shared_memory() const { return transport == "shm"; }
  /// Returns the number of all bytes that were sent, including those while fields were recorded: on the
  /// wire if that was measured, otherwise of the payload.
  double bytes() const;
  /// Returns the bytes of a sample in the steady state: if fields are recorded, after the mask had
  /// narrowed. Empty if no sample arrived after that.
  std::optional<double> bytes_per_sample() const;
  /// Returns the bytes on the wire until the recorded mask had narrowed; empty if they were not measured.
  std::optional<double> learning_bytes() const;
  /// Returns the share of the bytes of all whole messages that was not sent to the subscriber.
  double saved() const;
  /// Counts the published samples that did not arrive as lost. Must be called when no sample can arrive any
  /// more. A subscriber itself does not detect that samples after the last received sample are missing.
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
  double carried_bytes() const;  ///< bytes that were sent to these subscribers
  double whole_bytes() const;    ///< bytes of all whole messages to these subscribers
};

nlohmann::ordered_json to_json(const RunFigures& run);

/// Returns "header, width", "all", or "header, 1 Hz".
std::string format_request(const SubscriberFigures& subscriber);

/// Returns the lines of the table: the head, and a line per subscriber.
std::vector<std::string> format_table(const RunFigures& run);

/// Returns one line: "12.0 s: 120 published; the network carried 78.61 MB, not 3.02 GB; 0 lost".
std::string format_progress(const RunFigures& run, double elapsed_s);

/// Returns lines for users who have not read the code. The first line has the result.
std::vector<std::string> format_summary(const RunFigures& run);

/// Returns one line for each system feature that would make the demo faster, but that the publisher's host
/// does not allow.
std::vector<std::string> format_refusals(const PublisherReport& publisher);

}  // namespace sft::demo
