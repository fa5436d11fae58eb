// The laws of the simulated world, which must hold after each event and at the end. Both hosts report their
// actions, and the laws compare the reports. The first violation is kept.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/seam/sample_buffer.h"
#include "core/subscribe/sequence_account.h"
#include "tests/simulation/udp/loss_account.h"
#include "tests/simulation/udp/scenario.h"
#include "tests/simulation/udp/topic.h"
#include "udp_transport/reliable/resend_window.h"
#include "udp_transport/wire/datagram.h"

namespace sft::simulation {

class Laws {
 public:
  /// `scenario` must outlive the laws.
  explicit Laws(const Scenario& scenario) : scenario_(scenario), next_sequence_(scenario.first_sequence) {}

  /// Returns the first violation, or "" if there is none.
  const std::string& violation() const { return violation_; }
  void fail(const std::string& what);
  /// Records a violation, unless a forged datagram may be the cause.
  void fail_unless_forged(const std::string& what);
  LossAccount& loss_account() { return loss_account_; }

  // Reports of the writer.

  void published(std::uint64_t sequence, Cloud cloud, Time now);
  /// Records that the sample was sent to that reader. The writer might not know yet that the reader has left.
  void owes(core::EndpointId reader, const Variant& sample) {
    if (!left_.contains(reader)) readers_[reader].owed.push_back(sample);
  }
  /// Records that the conditions of that reader have withheld the sample.
  void withholds(core::EndpointId reader, std::uint64_t sequence) {
    if (!left_.contains(reader)) readers_[reader].withheld.insert(sequence);
  }
  /// Records that the sample has passed that gate, with that ordinal.
  void let_pass(std::uint64_t gate, std::uint64_t sequence, std::uint32_t ordinal) {
    passed_[gate].emplace(sequence, ordinal);
    if (ordinal == 1) begun_[gate].insert(sequence);
  }

  // Reports of the readers' process.

  void process_started();
  void process_crashed() { readers_.clear(); }
  void reader_joined(core::EndpointId reader) {
    readers_.try_emplace(reader);
    left_.erase(reader);
  }
  void reader_left(core::EndpointId reader) {
    readers_.erase(reader);
    left_.insert(reader);
  }
  /// Records that the reader requests that selection from now on.
  void asks(core::EndpointId reader, const Selection& wish);
  /// Records that the writer knows the reader's latest wish from now on.
  void is_heard(core::EndpointId reader) { readers_[reader].known_from = next_sequence_; }
  /// Records that a whole sample arrived, which best-effort readers would take at once.
  void came(const core::SampleBuffer& sample);
  /// Records that a sample arrived and was passed over, because no reader of the process had requested its
  /// selection. The sample is `behind` places after the first sample of a datagram.
  void refused(const udp::FirstHeader& first, std::uint64_t behind);
  /// Records that the reader was given a sample. `changes` is true while the reader changes from one wish to
  /// another.
  void taken(core::EndpointId reader, const core::SampleBuffer& sample, bool changes);

  // Checks of the laws.

  /// Checks the laws that hold after each event. `arrivals` is null while the process of the readers is down.
  void check(const udp::ResendWindow& sent, udp::ArrivalWindow* arrivals);
  /// Checks the laws that hold when no datagram is under way any more. `channel` is the last channel of the
  /// writer.
  void check_end(const udp::ResendWindow& sent, std::uint32_t channel);
  /// Checks that no state of former wishes is kept after samples have arrived under the latest wishes.
  void check_settled();

 private:
  /// The samples that one reader has to get, and the samples that it has got.
  struct Account {
    std::vector<Variant> owed{};
    std::set<std::uint64_t> got{};         ///< the sequences of the samples that arrived
    std::uint64_t last = 0;                ///< the sequence of the last sample that the reader got
    std::uint64_t last_gate = 0;           ///< the gate that the last sample has passed; 0: none
    std::set<std::uint64_t> last_names{};  ///< the selections under which the last sample arrived
    bool changed = false;                  ///< whether the reader was changing its wish then
    std::set<std::uint64_t> names{};       ///< the hashes of all selections that the reader has requested
    std::set<std::uint64_t> gates{};       ///< gates that the samples after the last one may have; 0: no gate
    /// The gates that samples after the next one may have. If there are none here, `gates` has them.
    std::set<std::uint64_t> later_gates{};
    std::uint64_t gate = 0;              ///< the gate of the reader's latest wish
    std::uint64_t known_from = 0;        ///< the first sequence under the latest wish; 0: none yet
    bool is_settled = false;             ///< whether a sample under the latest wish has arrived
    std::set<std::uint64_t> withheld{};  ///< the sequences of the withheld samples
    core::SequenceAccount numbers{};     ///< counts missing samples as a subscriber does
    core::AskedGates asked{};            ///< tracks the gates as a subscriber does
  };

  bool is_sound(const core::SampleBuffer& sample, const std::string& which);
  bool has_passed_its_gate(const core::SampleBuffer& sample) const;
  void check_missing(Account& account, const core::SampleBuffer& sample, const std::string& which);
  void check_losses(udp::ArrivalWindow& arrivals);
  void check_end(core::EndpointId reader, const Account& account);
  void check_end_after_forgeries(const Account& account);

  const Scenario& scenario_;
  std::string violation_;
  std::uint64_t next_sequence_;
  /// The sequence of the first sample published at least a second after the last forgery.
  std::uint64_t first_owed_ = 0;
  struct Published {
    Cloud cloud;
    std::map<std::uint64_t, std::vector<std::byte>> bodies{};  ///< bodies by the hash of their selection
  };
  std::map<std::uint64_t, Published> published_;
  std::map<core::EndpointId, Account> readers_;
  std::set<core::EndpointId> left_;  ///< readers that left and did not come back
  LossAccount loss_account_;
  /// The ordinals of samples in gates, by gate and sequence.
  std::map<std::uint64_t, std::map<std::uint64_t, std::uint32_t>> passed_;
  /// The sequences of the samples with which each gate began. A gate begins again if the writer has removed
  /// it meanwhile.
  std::map<std::uint64_t, std::set<std::uint64_t>> begun_;
  std::uint64_t lost_ = 0;  ///< the number of lost samples that the process had counted at the last check
};

}  // namespace sft::simulation
