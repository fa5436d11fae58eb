// An account of all samples that were sent in channels, and of the samples that the present process of the
// readers knows of. The account gives the number of samples that this process has to count as lost.
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
  std::uint64_t selection = 0;  ///< the hash of the selection, or of the union of masks
  friend auto operator<=>(const Variant&, const Variant&) = default;
};

class LossAccount {
 public:
  // Reports of the writer.

  void sent(std::uint32_t channel, std::uint64_t ordinal, const Variant& sample);
  /// Records that the writer has dropped this sample although it was not acknowledged.
  void dropped(std::uint32_t channel, std::uint64_t ordinal);
  bool was_dropped(std::uint64_t sequence) const { return dropped_.contains(sequence); }

  // Reports of the readers' process.

  /// Records the start of a new process, which knows nothing of former samples.
  void process_started();
  /// Records that a datagram, perhaps this heartbeat, has changed the mark of the process's window from
  /// `before` to `mark`. With the first datagram of a channel, all samples that are missing in the former
  /// channel are lost.
  void heard(const std::optional<udp::ArrivalWindow::Mark>& before,
             const std::optional<udp::ArrivalWindow::Mark>& mark,
             const std::optional<udp::Heartbeat>& heartbeat);
  /// Records that the sample arrived. Returns false if the same sample had arrived before.
  bool came(const Variant& sample) { return came_.insert(sample).second; }
  /// Records that the sample arrived although no reader of the process had requested its selection.
  void refused(const Variant& sample) { refused_.insert(sample); }

  bool has_come(const Variant& sample) const { return came_.contains(sample); }
  bool was_refused(const Variant& sample) const { return refused_.contains(sample); }
  /// Returns true if that sample or a later one has arrived.
  bool anything_came_from(std::uint64_t sequence) const {
    return came_.lower_bound({sequence, 0}) != came_.end();
  }

  /// Returns the number of samples that the process has to count as lost, if its window is in this channel
  /// and has handed over all samples before `next`.
  std::uint64_t lost(std::uint32_t channel, udp::ArrivalWindow::Place next) const;
  /// Returns the number of samples that the process has to count as lost after all datagrams have arrived.
  /// `channel` is the last channel.
  std::uint64_t lost_in_the_end(std::uint32_t channel);

 private:
  struct Channel {
    std::map<std::uint64_t, Variant> sent{};    ///< the samples that were sent, by ordinal
    std::optional<std::uint64_t> known_from{};  ///< the first ordinal that the process knows of
    std::uint64_t gone_before = 0;  ///< the process knows that no sample before this ordinal will arrive
    std::uint64_t base = 0;         ///< the place of ordinal 0 in the window
  };
  std::uint64_t missing(const Channel& channel, std::uint64_t end) const;

  std::map<std::uint32_t, Channel> channels_;  ///< channels by number
  std::set<std::uint64_t> dropped_;            ///< the sequences of the dropped samples
  std::set<Variant> came_;
  std::set<Variant> refused_;
};

}  // namespace sft::simulation
