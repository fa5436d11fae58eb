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

/// One of the ways in which the message was sent: the selection, the whole message, or plain sockets.
struct Lane {
  std::string name{};    ///< "sft", "whole", "udp" or "tcp"
  std::string fields{};  ///< empty for plain sockets
  std::string path{};    ///< "shm", "udp" or "tcp"; several with "+"
  double message_bytes = 0;

  std::uint64_t sent = 0;      ///< times the number of sides that answer
  std::uint64_t refused = 0;   ///< no memory was free, or the system refused
  std::uint64_t late = 0;      ///< sent too late: the time counts from when they were due
  std::uint64_t arrived = 0;   ///< at the other sides
  std::uint64_t returned = 0;  ///< answers, each sample once
  std::uint64_t reordered = 0;
  std::uint64_t twice = 0;
  double seconds = 0;   ///< while samples were sent
  Histogram latency{};  ///< half of each round trip
  Histogram there{}, back{};
  double jitter_sum_s = 0;  ///< differences of consecutive latencies of one side
  std::uint64_t jitter_count = 0;
  std::optional<double> first_s{};  ///< of the first sample, which is not in `latency`
  Usage here{}, far{};

  std::optional<double> jitter_s() const;
  Values values(bool answers) const;
};

struct Outcome {
  std::vector<Lane> lanes{};
  bool answers = true;
  bool interrupted = false;
  double rate_hz = 0;  ///< as asked for; 0: as fast as possible
  std::string type{}, reliability{};
  std::size_t sides = 0;
  std::string error{};   ///< why it ended early
  std::string clocks{};  ///< words of Agreement
  std::optional<double> clocks_within_s{};
  /// The time of the other host's clock minus that of this one, by the quickest round trip, and by how much
  /// that may be wrong.
  std::optional<double> offset_s{};
  double offset_error_s = 0;
  bool any_negative = false;  ///< a one-way time was less than 0
  std::vector<std::string> remarks{};
};

/// Returns the reason why a run has no one-way times; empty if it has them. A time less than 0 proves that
/// the clocks differ, whatever their hosts say.
std::string why_no_one_way(const Outcome& run);

nlohmann::ordered_json json_of(const Outcome& run, const std::vector<std::string>& failed);
/// Returns lines for people.
std::string text_of(const Outcome& run);
/// Returns a picture of the latencies: for each lane the part of samples that took longer, on logarithmic
/// axes.
std::string svg_of(const Outcome& run);

}  // namespace sft::perf
