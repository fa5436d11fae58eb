// The results of a run, as values, text, JSON and a picture.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/perf/criteria.h"
#include "tools/perf/histogram.h"
#include "tools/perf/usage.h"

namespace sft::perf {

/// The results of one of the ways in which the message was sent: with the selection, as whole message, or
/// by plain sockets.
struct Lane {
  std::string name{};    ///< "sft", "whole", "udp" or "tcp"
  std::string fields{};  ///< the selection; empty for plain sockets
  std::string path{};    ///< "shm", "udp" or "tcp"; several paths are joined by "+"
  double message_bytes = 0;

  std::uint64_t sent = 0;  ///< the number of samples times the number of sides that answer
  /// samples that were not sent, because no memory was free or the system refused
  std::uint64_t refused = 0;
  std::uint64_t late = 0;      ///< samples that were sent too late; their times count from the planned time
  std::uint64_t arrived = 0;   ///< samples that arrived at the other sides
  std::uint64_t returned = 0;  ///< samples that were answered
  std::uint64_t reordered = 0;
  std::uint64_t twice = 0;
  double seconds = 0;   ///< the time during which samples were sent
  Histogram latency{};  ///< half of each round trip
  Histogram there{}, back{};
  double jitter_sum_s = 0;  ///< the sum of the differences of consecutive latencies of one side
  std::uint64_t jitter_count = 0;
  std::optional<double> first_s{};  ///< the latency of the first sample, which is not in `latency`
  Usage here{}, far{};

  std::optional<double> jitter_s() const;
  Values values(bool answers) const;
};

struct Outcome {
  std::vector<Lane> lanes{};
  bool answers = true;
  bool interrupted = false;
  double rate_hz = 0;  ///< the requested rate; 0: as fast as possible
  std::string type{}, reliability{};
  std::size_t sides = 0;
  std::string error{};   ///< the reason why the run ended early; empty: it did not
  std::string clocks{};  ///< the value of Agreement::words
  std::optional<double> clocks_within_s{};
  /// The other host's clock minus this host's clock in seconds, measured by the fastest round trip, and the
  /// maximum error of this difference.
  std::optional<double> offset_s{};
  double offset_error_s = 0;
  bool any_negative = false;  ///< true: a one-way time was less than 0
  std::vector<std::string> remarks{};
};

/// Returns the reason why a run has no one-way times; empty if it has them. A time of less than 0 proves
/// that the clocks differ, even if both hosts report that they are synchronised.
std::string why_no_one_way(const Outcome& run);

nlohmann::ordered_json json_of(const Outcome& run, const std::vector<std::string>& failed);
/// Returns the results as lines of text for people.
std::string text_of(const Outcome& run);
/// Returns a picture of the latencies on logarithmic axes: for each lane, the share of the samples that
/// took longer than a time.
std::string svg_of(const Outcome& run);

}  // namespace sft::perf
