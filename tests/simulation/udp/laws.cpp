#include "tests/simulation/udp/laws.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <utility>

#include "core/seam/gate.h"

namespace sft::simulation {
namespace {

using namespace std::chrono_literals;

std::string name_of(std::uint64_t sequence) { return "sample " + std::to_string(sequence); }

std::string name_of(std::uint64_t sequence, core::EndpointId reader) {
  return name_of(sequence) + " of reader " + std::to_string(reader);
}

}  // namespace

void Laws::fail(const std::string& what) {
  if (violation_.empty()) violation_ = what;
}

void Laws::fail_unless_forged(const std::string& what) {
  if (!scenario_.forgers) fail(what);
}

void Laws::published(std::uint64_t sequence, Cloud cloud, Time now) {
  published_.emplace(sequence, Published{std::move(cloud)});
  next_sequence_ = sequence + 1;
  if (scenario_.forgers && now < scenario_.weather.forged_until + 1s) first_owed_ = next_sequence_;
}

void Laws::process_started() {
  readers_.clear();
  loss_account_.process_started();
  lost_ = 0;
}

void Laws::asks(core::EndpointId reader, const Selection& wish) {
  Account& account = readers_[reader];
  const std::uint64_t gate = core::gate_id(wish.gate_hash(), 0);
  account.names.insert(wish.hash());
  account.gates.insert(gate);
  if (!account.later_gates.empty()) account.later_gates.insert(gate);
  account.gate = gate;
  account.known_from = 0;
  account.is_settled = false;
  account.asked.ask(gate);
}

void Laws::came(const core::SampleBuffer& sample) {
  if (scenario_.forgers) return;
  const std::string which = name_of(sample.sequence);
  if (is_sound(sample, which) && !loss_account_.came({sample.sequence, name_of_selection(sample)}))
    fail(which + " comes twice");
}

void Laws::refused(const udp::FirstHeader& first, std::uint64_t behind) {
  if (scenario_.forgers) return;
  const std::uint64_t sequence = udp::widen_sequence(next_sequence_, first.label.sequence);
  loss_account_.refused({sequence + behind, first.mask});
}

void Laws::taken(core::EndpointId reader, const core::SampleBuffer& sample, bool changes) {
  const std::string which = name_of(sample.sequence, reader);
  Account& account = readers_[reader];
  if (scenario_.forgers && sample.sequence < first_owed_) return;
  if (scenario_.forgers && !published_.contains(sample.sequence)) return;
  if (!is_sound(sample, which)) return;
  if (scenario_.forgers) return static_cast<void>(account.got.insert(sample.sequence));
  if (!sample.merged && !account.names.contains(name_of_selection(sample)))
    return fail(which + " is of something that it has never asked for");
  if (sample.sequence == account.last) {
    // While a reader of the process changes its wish, a sample can arrive under both selections.
    const bool may_repeat = account.changed || changes;
    if (!may_repeat || !account.last_names.insert(name_of_selection(sample)).second)
      fail(which + " comes twice");
    return;
  }
  if (sample.sequence < account.last) return fail(which + " comes after " + std::to_string(account.last));
  check_missing(account, sample, which);
  if (!account.later_gates.empty()) account.gates = std::exchange(account.later_gates, {});
  if (account.known_from != 0 && sample.sequence >= account.known_from) {
    account.asked.settle(account.asked.latest());
    account.is_settled = true;
    account.later_gates = {account.gate};
  }
  account.last = sample.sequence;
  account.last_gate = sample.gate;
  account.last_names = {name_of_selection(sample)};
  account.changed = changes;
  account.got.insert(sample.sequence);
}

/// Checks the number of samples before this one that count as lost. Withheld samples must not count. If the
/// reader requests all samples, each sample that did not arrive must count. Between two samples of one gate,
/// each sample that has passed the gate and did not arrive must count. This is checked only if no other
/// conditions can have been in force and the gate did not begin anew.
void Laws::check_missing(Account& account, const core::SampleBuffer& sample, const std::string& which) {
  const std::uint64_t before = account.last;
  const std::uint64_t lost = account.numbers.enter(sample, core::RateKeeper::writer, account.asked).lost;
  if (before == 0) return;
  const std::uint64_t gap = sample.sequence - before - 1;
  const auto between = [&](const auto& sequences) {
    return static_cast<std::uint64_t>(
        std::distance(sequences.upper_bound(before), sequences.lower_bound(sample.sequence)));
  };
  const auto suits = [&](std::uint64_t gate) { return gate == 0 || gate == sample.gate; };
  const bool asks_for_all = account.gates == std::set<std::uint64_t>{0};
  const auto& begun = begun_[sample.gate];
  const bool is_numbered = sample.gate == account.last_gate && std::ranges::all_of(account.gates, suits) &&
                           begun.upper_bound(before) == begun.upper_bound(sample.sequence);
  if (asks_for_all || is_numbered) {
    const std::uint64_t missing = asks_for_all ? gap : between(passed_[sample.gate]);
    if (lost != missing)
      fail(which + ": " + std::to_string(lost) + " before it count as lost, and " + std::to_string(missing) +
           " that have passed did not come");
  }
  const std::uint64_t withheld = between(account.withheld);
  if (lost + withheld > gap)
    fail(which + ": " + std::to_string(lost) + " before it count as lost of " + std::to_string(gap) +
         ", of which " + std::to_string(withheld) + " were withheld");
}

bool Laws::has_passed_its_gate(const core::SampleBuffer& sample) const {
  if (sample.gate == 0) return true;
  const auto gate = passed_.find(sample.gate);
  if (gate == passed_.end()) return false;
  const auto passed = gate->second.find(sample.sequence);
  return passed != gate->second.end() && passed->second == sample.ordinal;
}

/// Returns true if the sample has the published content of the selection that it names, and has passed the
/// gate of that selection.
bool Laws::is_sound(const core::SampleBuffer& sample, const std::string& which) {
  if (sample.writer != writer_id) return fail(which + " names another writer"), false;
  const auto published = published_.find(sample.sequence);
  if (published == published_.end()) return fail(which + " was never published"), false;
  const std::span<const std::byte> body(sample.data + sample.header().body_offset,
                                        sample.header().body_bytes);
  const std::uint64_t name = name_of_selection(sample);
  if (name == 0) return fail(which + " is of no selection that is known"), false;
  if (!has_passed_its_gate(sample)) return fail(which + " was withheld, or has another number"), false;
  const auto [right, is_first] = published->second.bodies.try_emplace(name);
  if (is_first) right->second = body_under(published->second.cloud, sample);
  if (udp::test::same_bytes(body, right->second)) return true;
  return fail(which + " has other bytes, or those of another selection"), false;
}

void Laws::check(const udp::ResendWindow& sent, udp::ArrivalWindow* arrivals) {
  if (sent.kept() > scenario_.resend.samples) fail("the writer keeps too many samples");
  if (sent.kept_bytes() > scenario_.resend.bytes && sent.kept() > 1) fail("the writer keeps too much");
  if (arrivals == nullptr) return;
  const udp::ArrivalLimits& limits = scenario_.reassembly.channel;
  if (arrivals->samples().slots().size() > limits.samples) fail("the reader keeps too many places");
  const std::size_t buffer_bytes_max = 2 * scenario_.sample_bytes_max;
  const std::size_t most = scenario_.readers_lag ? limits.awaited_bytes + buffer_bytes_max
                                                 : limits.held_bytes + scenario_.sample_bytes_max;
  if (arrivals->samples().held_bytes() > most) fail("the reader holds back too much");
  if (!scenario_.forgers) check_losses(*arrivals);
}

/// Checks that the process has counted each lost sample once and in order. All counted samples precede the
/// samples that may still arrive.
void Laws::check_losses(udp::ArrivalWindow& arrivals) {
  const auto mark = arrivals.mark();
  if (arrivals.samples().lost() == lost_ || !mark) return;
  lost_ = arrivals.samples().lost();
  const std::uint64_t missing = loss_account_.lost(mark->channel, arrivals.samples().next());
  if (missing != lost_)
    fail(std::to_string(lost_) + " are said to be lost, and " + std::to_string(missing) + " did not come");
}

void Laws::check_end(const udp::ResendWindow& sent, std::uint32_t channel) {
  if (readers_.empty()) return;
  if (!sent.settled()) fail("the writer waits for an ack that does not come");
  const std::uint64_t missing = loss_account_.lost_in_the_end(channel);
  if (missing != lost_)
    fail_unless_forged(std::to_string(missing) + " did not come, and " + std::to_string(lost_) +
                       " are said to be lost");
  for (const auto& [reader, account] : readers_)
    scenario_.forgers ? check_end_after_forgeries(account) : check_end(reader, account);
}

void Laws::check_settled() {
  for (const auto& [reader, account] : readers_) {
    const bool has_changed = account.known_from != 0;
    if (has_changed && !account.is_settled)
      return fail("reader " + std::to_string(reader) + " gets nothing under its latest wish");
    if (account.asked.nameable().size() > 1)
      return fail("reader " + std::to_string(reader) + " keeps former conditions");
  }
}

void Laws::check_end(core::EndpointId reader, const Account& account) {
  for (const Variant& sample : account.owed) {
    if (account.got.contains(sample.sequence)) continue;
    const std::string which = name_of(sample.sequence, reader);
    if (loss_account_.was_refused(sample)) return fail(which + " came, and was refused");
    if (loss_account_.has_come(sample)) return fail(which + " came, and was not handed over");
    if (loss_account_.was_dropped(sample.sequence)) continue;
    if (!scenario_.tight_reader) return fail(which + " did not come");
    if (!loss_account_.anything_came_from(sample.sequence))
      return fail(which + " is lost, and nothing behind it came");
  }
}

/// Checks that at most 1 % of the samples are missing. Rarely a forged sample takes the place of a later true
/// sample, because the two cannot be distinguished.
void Laws::check_end_after_forgeries(const Account& account) {
  std::size_t owed = 0, missing = 0;
  for (const Variant& sample : account.owed) {
    if (sample.sequence < first_owed_ || loss_account_.was_dropped(sample.sequence)) continue;
    ++owed;
    missing += account.got.contains(sample.sequence) ? 0 : 1;
  }
  if (owed < 50) fail("it was not looked at for long enough");
  if (100 * missing > owed)
    fail(std::to_string(missing) + " of " + std::to_string(owed) + " samples did not come");
}

}  // namespace sft::simulation
