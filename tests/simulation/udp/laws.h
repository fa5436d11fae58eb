// The laws of the simulated world, which must hold after each event and at the end. The hosts report what
// they do, and the laws compare both sides. The first violation is kept.
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
  /// `scenario` outlives the laws.
  explicit Laws(const Scenario& scenario) : scenario_(scenario), next_sequence_(scenario.first_sequence) {}

  /// Returns the first violation; empty if there is none.
  const std::string& violation() const { return violation_; }
  void fail(const std::string& what);
  /// Fails, unless a forged datagram can be the cause.
  void fail_unless_forged(const std::string& what);
  LossAccount& loss_account() { return loss_account_; }

  // Reports of the writer.

  void published(std::uint64_t sequence, Cloud cloud, Time now);
  /// Notes that the sample was sent to that reader. The writer might not know yet that the reader has left.
  void owes(core::EndpointId reader, const Variant& sample) {
    if (!left_.contains(reader)) readers_[reader].owed.push_back(sample);
  }
  /// Notes that the conditions of that reader have withheld the sample.
  void withholds(core::EndpointId reader, std::uint64_t sequence) {
    if (!left_.contains(reader)) readers_[reader].withheld.insert(sequence);
  }
  /// Notes that the sample has passed that gate with that ordinal.
  void let_pass(std::uint64_t gate, std::uint64_t sequence, std::uint32_t ordinal) {
    passed_[gate].emplace(sequence, ordinal);
    if (ordinal == 1) begun_[gate].insert(sequence);
  }

  // Reports of the process of the readers.

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
  /// Notes that the reader asks for that selection from now on.
  void asks(core::EndpointId reader, const Selection& wish);
  /// Notes that the writer knows the reader's latest wish from now on.
  void is_heard(core::EndpointId reader) { readers_[reader].known_from = next_sequence_; }
  /// Notes that a whole sample came, which best-effort readers would take at once.
  void came(const core::SampleBuffer& sample);
  /// Notes that a sample came and was passed over, because no reader of the process had asked for it. It is
  /// `behind` places after the first sample of a datagram.
  void refused(const udp::FirstHeader& first, std::uint64_t behind);
  /// Notes that the reader was given a sample. `changes`: the reader is changing from one wish to another.
  void taken(core::EndpointId reader, const core::SampleBuffer& sample, bool changes);

  // Checks.

  /// Checks what must hold after each event. `arrivals`: null while the process of the readers is down.
  void check(const udp::ResendWindow& sent, udp::ArrivalWindow* arrivals);
  /// Checks what must hold when nothing is under way any more. `channel`: the last channel of the writer.
  void check_end(const udp::ResendWindow& sent, std::uint32_t channel);
  /// Checks that no state of former wishes is kept once samples have come under the latest ones.
  void check_settled();

 private:
  /// The samples that one reader has to get, and has got.
  struct Account {
    std::vector<Variant> owed{};
    std::set<std::uint64_t> got{};         ///< sequences of the samples that arrived
    std::uint64_t last = 0;                ///< sequence of the last sample that the reader got
    std::uint64_t last_gate = 0;           ///< the gate that this sample has passed; 0: none
    std::set<std::uint64_t> last_names{};  ///< selections under which that sample came
    bool changed = false;                  ///< the reader was changing its wish at that time
    std::set<std::uint64_t> names{};       ///< hashes of all its wishes
    std::set<std::uint64_t> gates{};       ///< gates that samples after the last may have; 0: no gate
    /// Gates that samples after the next one may have; empty: as `gates`.
    std::set<std::uint64_t> later_gates{};
    std::uint64_t gate = 0;              ///< gate of its latest wish
    std::uint64_t known_from = 0;        ///< first sequence under that wish; 0: none yet
    bool is_settled = false;             ///< has got a sample that was sent under its latest wish
    std::set<std::uint64_t> withheld{};  ///< sequences of the samples that were withheld
    core::SequenceAccount numbers{};     ///< counts missing samples as a subscriber does
    core::AskedGates asked{};            ///< follows gates as a subscriber does
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
  std::uint64_t first_owed_ = 0;  ///< the first sample that was published a second after the last forgery
  struct Published {
    Cloud cloud;
    std::map<std::uint64_t, std::vector<std::byte>> bodies{};  ///< by hash of the selection
  };
  std::map<std::uint64_t, Published> published_;
  std::map<core::EndpointId, Account> readers_;
  std::set<core::EndpointId> left_;  ///< readers that left and did not come back
  LossAccount loss_account_;
  /// Ordinals, by gate and sequence.
  std::map<std::uint64_t, std::map<std::uint64_t, std::uint32_t>> passed_;
  /// The sequences with which each gate began. A gate begins again if the writer has removed it meanwhile.
  std::map<std::uint64_t, std::set<std::uint64_t>> begun_;
  std::uint64_t lost_ = 0;  ///< the process's count at the last check
};

}  // namespace sft::simulation
