// The accounts of all writers for one selection of a subscriber: the samples that arrived or are missing, and
// whether the writer keeps its deadline and liveliness. Uses no clock, thread or I/O. Not thread-safe: the
// mutex of SubscriberPorts protects the accounts.
#pragma once

#include <cstdint>
#include <vector>

#include "core/negotiation/hearing.h"
#include "core/subscribe/sequence_account.h"
#include "sft/status.h"

namespace sft::core {

class WriterAccounts {
 public:
  struct Writer {
    EndpointId id = 0;
    SequenceAccount sequences;
    bool last_over_network = false;  ///< true: the sample that was entered last came by UDP
    std::uint64_t received = 0;
    std::uint64_t lost = 0;
    std::uint64_t withheld = 0;
    std::uint64_t lost_untold = 0;  ///< the part of `lost` that no delivered sample has reported yet
    std::uint64_t expired = 0;
    std::int64_t since_ns = 0;     ///< the time when the subscriber began to receive from the writer
    std::int64_t lifespan_ns = 0;  ///< the lifespan of the writer's samples; 0: they do not expire
    std::uint64_t deadlines_missed = 0;
    std::uint64_t restarts = 0;
    bool alive = true;
  };

  explicit WriterAccounts(std::uint32_t min_period_us) : min_period_us_(min_period_us) {}

  /// Returns the account of that writer, and opens one if there is none. Valid until the next call.
  Writer& of(EndpointId writer) {
    for (Writer& known : writers_) {
      if (known.id == writer) return known;
    }
    return open(writer);
  }
  /// Returns the account of that writer, or null if there is none.
  const Writer* find(EndpointId writer) const;

  /// Sets the least time between two samples, by the maximum rate that the subscriber asks for; 0: all
  /// samples.
  void ask(std::uint32_t min_period_us);
  /// Sets the conditions that the subscriber asks for, by their hash (Selection::gate_hash()); 0: none.
  void ask_conditions(std::uint64_t hash);
  /// Called when no sample of requests before number `these` is under way, or waits, any more.
  void forget_conditions_before(AskedGates::Number these) { asked_gates_.settle(these); }
  const AskedGates& asked_gates() const { return asked_gates_; }
  /// Returns true if, according to the numbers, no sample of the writer is missing before this one.
  bool follows(const SampleOrigin& sample) {
    return of(sample.writer).sequences.follows(sample, asked_gates_);
  }
  std::uint32_t min_period_us() const { return min_period_us_; }
  /// Sets the writers from which the subscriber receives from now on.
  void hears(const std::vector<Hearing>& hearing, std::int64_t now_ns);

  /// Enters a new sample in its writer's account, and counts the samples that are missing before it.
  void enter(Writer& writer, const SampleOrigin& sample, RateKeeper keeper) {
    const SequenceAccount::Missing missing = writer.sequences.enter(sample, keeper, asked_gates_);
    writer.lost += missing.lost;
    writer.lost_untold += missing.lost;
    losses_ += missing.lost;
    writer.withheld += missing.withheld;
    writer.last_over_network = keeper == RateKeeper::writer;
  }
  /// Counts a sample as lost that was entered and could not be delivered later.
  void lose_entered(EndpointId writer, std::uint64_t lost_before);

  /// Adds deadlines that the writer has missed, and sets if the writer is alive. Returns true if status()
  /// changes.
  bool keeps_promises(EndpointId writer, std::uint64_t more_missed, bool alive);

  /// Returns the number of lost samples of all writers.
  std::uint64_t losses() const { return losses_; }
  /// Adds the counts of all writers, and fills in `writers`.
  void describe(SubscriberStatus& status) const;

 private:
  Writer& open(EndpointId writer);
  void ask_all();
  bool is_heard(const Writer& writer) const;
  void forget_departed();
  template <class Sum>
  static void add(Sum& sum, const Writer& writer);
  static void fill_in(SubscriberStatus::Writer& status, const Writer& writer);

  std::uint32_t min_period_us_;
  std::uint64_t conditions_ = 0;
  AskedGates asked_gates_;
  std::vector<Writer> writers_;
  /// The present writers, as the negotiation describes them.
  std::vector<SubscriberStatus::Writer> heard_;
  Writer forgotten_;  ///< the sums of the accounts that were removed
  std::uint64_t losses_ = 0;
};

}  // namespace sft::core
