// An account of all samples that were sent in channels, and of those that the present process of the readers
// knows of. From it follows how many samples this process has to count as lost.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "udp_transport/reliable/arrival_window.h"

namespace sft::simulation {

/// One encoding of a sample.
struct Variant {
  std::uint64_t sequence = 0;
  std::uint64_t selection = 0;  ///< hash of the selection, or of the union of masks
  friend auto operator<=>(const Variant&, const Variant&) = default;
};

class LossAccount {
 public:
  // Reports of the writer.

  void sent(std::uint32_t channel, std::uint64_t ordinal, const Variant& sample);
  /// Notes that the writer does not keep this sample any more, although it was not acknowledged.
  void dropped(std::uint32_t channel, std::uint64_t ordinal);
  bool was_dropped(std::uint64_t sequence) const { return dropped_.contains(sequence); }

  // Reports of the process of the readers.

  /// Notes a new process, which knows nothing of former samples.
  void process_started();
  /// Notes that a datagram, perhaps this heartbeat, has changed the window of the process from `before` to
  /// `mark`. With the first datagram of a channel, everything that is missing of the former channel is lost.
  void heard(const std::optional<udp::ArrivalWindow::Mark>& before,
             const std::optional<udp::ArrivalWindow::Mark>& mark,
             const std::optional<udp::Heartbeat>& heartbeat);
  /// Returns false if the same sample had come before.
  bool came(const Variant& sample) { return came_.insert(sample).second; }
  /// Notes that the sample came although no reader of the process had asked for it.
  void refused(const Variant& sample) { refused_.insert(sample); }

  bool has_come(const Variant& sample) const { return came_.contains(sample); }
  bool was_refused(const Variant& sample) const { return refused_.contains(sample); }
  /// Returns true if that sample or a later one came.
  bool anything_came_from(std::uint64_t sequence) const {
    return came_.lower_bound({sequence, 0}) != came_.end();
  }

  /// Returns how many samples the process has to count as lost if its window is in this channel and has
  /// handed over all samples before `next`.
  std::uint64_t lost(std::uint32_t channel, udp::ArrivalWindow::Place next) const;
  /// Returns that number when nothing is under way any more. `channel`: the last channel.
  std::uint64_t lost_in_the_end(std::uint32_t channel);

 private:
  struct Channel {
    std::map<std::uint64_t, Variant> sent{};    ///< by ordinal
    std::optional<std::uint64_t> known_from{};  ///< ordinal with which the process began
    std::uint64_t gone_before = 0;  ///< samples before this ordinal will not come, as the process knows
    std::uint64_t base = 0;         ///< place of ordinal 0 in the window
  };
  std::uint64_t missing(const Channel& channel, std::uint64_t end) const;

  std::map<std::uint32_t, Channel> channels_;  ///< by number
  std::set<std::uint64_t> dropped_;            ///< sequences of the dropped samples
  std::set<Variant> came_;
  std::set<Variant> refused_;
};

}  // namespace sft::simulation
