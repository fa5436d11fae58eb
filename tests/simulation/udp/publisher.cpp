#include "tests/simulation/udp/publisher.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace sft::simulation {

void Publisher::publish(const std::map<core::EndpointId, Wish>& asked, Time now) {
  std::set<Wish> served;
  for (const auto& [reader, wish] : asked) served.insert(wish);
  FieldMask all = cloud_type().none();
  for (const Wish wish : served) all |= wishes()[wish].mask();
  const bool only_masks = served.empty() || *served.rbegin() < masks_end;
  const bool some_samples =
      std::ranges::any_of(served, [](Wish wish) { return !wishes()[wish].gate().is_open(); });
  // Such readers share no group, see GroupKeeper::look_at().
  if (some_samples && served.size() > 1) group_.leave();
  const Selection together = served.size() == 1 ? wishes()[*served.begin()] : Selection(all);
  const bool may_span = served.size() == 1 && only_masks && !group_.exists();
  std::vector<Cloud> clouds = next_clouds(may_span);
  const GatesInForce gates = give_gates(asked);
  ask_gates(gates, clouds.front());
  const auto passes = [&](Wish wish) { return !gates.contains(wish) || gates.at(wish)->passes(); };
  for (const Wish wish : served) {
    if (group_.exists() || !passes(wish)) continue;
    const udp::JobHandle job = encode(clouds, wishes()[wish], static_cast<std::uint16_t>(wish));
    mark(*job, wish, gates);
    channel_.keep(job);
  }
  if (group_.exists() && !served.empty() && passes(*served.begin())) {
    const udp::JobHandle job = encode({&clouds.front(), 1}, together, number_of(served));
    if (together.is_mask()) job->first.flags |= udp::merged_masks;
    if (gates.contains(*served.begin())) ++gated_by_group_;
    mark(*job, *served.begin(), gates);
    group_.send(job, now);
  }
  for (Cloud& cloud : clouds) {
    for (const auto& [reader, wish] : asked) {
      const std::uint64_t name = (group_.exists() ? together : wishes()[wish]).hash();
      passes(wish) ? laws_.owes(reader, {sequence_, name}) : laws_.withholds(reader, sequence_);
    }
    laws_.published(sequence_++, std::move(cloud), now);
  }
  const bool is_last = ++published_ == scenario_.samples;
  publish_at_ = is_last ? Time::max() : now + std::chrono::microseconds(log_uniform(random_, 20'000));
  channel_.wake(now);
}

/// Puts the wishes into force, as Dispatch::serve() does with routes. Returns the gates of the wishes.
Publisher::GatesInForce Publisher::give_gates(const std::map<core::EndpointId, Wish>& asked) {
  core::Serving serving;
  for (const auto& [reader, wish] : asked)
    serving.network.push_back({.reader = reader, .destination = {}, .selection = wishes()[wish]});
  gates_.tidy();
  gates_.give(serving.network);
  gates_.open_for(serving);
  serving_ = std::move(serving);
  GatesInForce gates;
  for (const core::Route& route : serving_.network) {
    if (route.gate == nullptr) continue;
    gates[asked.at(route.reader)] = gates_.of(route);
    given_.insert_or_assign(route.gate.get(), route.gate);
  }
  return gates;
}

std::size_t Publisher::gates() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(given_, [](const auto& gate) { return !gate.second.expired(); }));
}

/// Makes each gate decide once about the cloud. Wishes with the same conditions share a gate.
void Publisher::ask_gates(const GatesInForce& gates, const Cloud& cloud) {
  std::set<core::Gate*> distinct;
  for (const auto& [wish, gate] : gates) distinct.insert(gate.get());
  const auto fields = detail::FieldSource::of_message(&cloud);
  for (core::Gate* gate : distinct) {
    gate->consider(fields, static_cast<std::int64_t>(sequence_));
    gate->made(fields, static_cast<std::int64_t>(sequence_));
    if (gate->passes()) laws_.let_pass(gate->id(), sequence_, gate->ordinal());
  }
}

/// Returns the next cloud. If `may_span`, sometimes returns several small clouds instead.
std::vector<Cloud> Publisher::next_clouds(bool may_span) {
  const bool is_span = may_span && happens(random_, scenario_.span);
  const double bytes_max = is_span ? 100 : static_cast<double>(scenario_.sample_bytes_max);
  std::vector<Cloud> clouds;
  for (std::size_t left = is_span ? from_to(random_, 2, 40) : 1; left > 0; --left) {
    const auto seed = static_cast<std::uint32_t>((sequence_ + clouds.size()) * 7);
    clouds.push_back(make_cloud(log_uniform(random_, bytes_max), seed));
  }
  return clouds;
}

/// Writes into the job that its sample has passed the gate of the wish, if the wish has a gate.
void Publisher::mark(udp::Job& job, Wish wish, const GatesInForce& gates) {
  if (!gates.contains(wish)) return;
  job.first.flags |= udp::rate_follows;
  job.first.rate = {0, gates.at(wish)->ordinal()};
}

/// Returns the number of the variant that serves all these wishes. The number is the same with and without
/// the group.
std::uint16_t Publisher::number_of(const std::set<Wish>& served) {
  if (served.size() == 1) return static_cast<std::uint16_t>(*served.begin());
  std::uint16_t number = 1000;
  for (const Wish wish : served) number += static_cast<std::uint16_t>(1U << wish);
  return number;
}

/// Encodes the clouds under the selection. Several clouds become a pack.
udp::JobHandle Publisher::encode(std::span<const Cloud> clouds, const Selection& selection,
                                 std::uint16_t variant) {
  const FieldMask all = cloud_type().full();
  udp::JobHandle job = jobs_->take();
  job->mask = std::make_shared<udp::WireMask>(udp::WireMask{variant, selection.hash(), {}});
  job->sequence = sequence_;
  job->first.label = {writer_label, static_cast<std::uint32_t>(sequence_), variant};
  job->first.flags = 0;
  job->first.rate = {};
  job->first.mask = job->mask->mask;
  for (const Cloud& cloud : clouds) {
    core::SampleHandle sample = memory_->take(udp::test::sample_bytes(cloud, all));
    udp::test::fill(*sample, cloud, all, writer_id, sequence_);
    project(*job, sample, selection, clouds.size() > 1);
  }
  if (clouds.size() > 1) job->seal();
  return job;
}

void Publisher::project(udp::Job& job, const core::SampleHandle& sample, const Selection& selection,
                        bool packed) {
  const detail::ProjectionPlan plan(cloud_type(), selection);
  const detail::SampleState state = core::state_of(*sample, cloud_type().index_slots());
  const bool done =
      plan.has_parts() ? job.projection.project(state, plan, {}) : job.projection.project(state, plan);
  if (!done) laws_.fail("a sample cannot be encoded");
  if (packed) return job.pack(job.projection.segments());
  job.first.total = static_cast<std::uint32_t>(job.projection.bytes());
  if (happens(random_, 0.5)) {
    job.copy_body();
  } else {
    job.sample = sample;
  }
}

}  // namespace sft::simulation
