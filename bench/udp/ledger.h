// Where the time of a sample went, from publish() to the callback: the phases follow each other, and their
// sum is the whole time. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bench/common/pair.h"
#include "bench/udp/wire_tap.h"

namespace sft::bench {

/// All times in microseconds.
struct Ledger {
  static constexpr std::array phase_names{"publish() called .. first byte leaves", ".. first byte arrives",
                                          ".. last byte leaves", ".. last byte arrives",
                                          ".. callback entered"};

  /// An event that happens beside the phases is no phase. A byte leaves or arrives when its packet passes the
  /// host's interface. Where the last byte leaves before the first one arrives, the third phase has no
  /// length.
  std::array<double, phase_names.size()> phases{};
  double publishing = 0;    ///< until publish() returned, which may be after the callback was entered
  double data_pause = 0;    ///< the longest one between two packets of the sample on their arrival
  double answer_pause = 0;  ///< the longest one between two answers on their arrival at the sender

  double total() const;
};

/// Nothing if no packet of the sample was noted at one of both ends. The packets may be those of several
/// samples, in their order.
std::optional<Ledger> ledger_of(const Delivery& delivery, const std::vector<Packet>& at_sender,
                                const std::vector<Packet>& at_receiver);

/// The median of each line. Unlike the phases of a sample, medians do not add up.
Ledger medians_of(const std::vector<Ledger>& ledgers);

/// A table of the sample's phases, their shares of its time, and the medians of all samples.
std::string table_of(const Ledger& ledger, const Ledger& medians);

/// The packets of one kind that pass one end of the link while a sample is under way.
struct Traffic {
  std::size_t packets = 0;
  std::uint64_t bytes = 0;
  std::int64_t first_ns = 0, last_ns = 0;
  std::int64_t pause_ns = 0, pause_at_ns = 0;  ///< the longest pause between two packets, and when it began

  void add(const Packet& packet);
};
Traffic traffic(const std::vector<Packet>& packets, const Delivery& during, bool outgoing, Packet::Kind kind);

}  // namespace sft::bench
