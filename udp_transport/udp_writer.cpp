#include "udp_transport/udp_writer.h"

#include <cassert>
#include <new>
#include <utility>

namespace sft::udp {

namespace {
/// Larger bodies are sent by the sending thread: the publisher goes on after a few datagrams.
constexpr std::size_t direct_bytes_max = 16 * 1024;
}  // namespace

UdpWriter::UdpWriter(const core::WriterSpec& spec, std::shared_ptr<SendSide> side)
    : writer_(static_cast<std::uint32_t>(spec.id)),
      type_(*spec.type),
      side_(std::move(side)),
      tally_(std::make_shared<WriterTally>()),
      variants_(side_->queue_depth, tally_),
      latest_routes_(std::make_shared<RouteTable>()),
      routes_(latest_routes_) {}

core::SampleHandle UdpWriter::loan(std::size_t bytes) noexcept { return side_->pool->take(bytes); }

std::uint64_t UdpWriter::bytes_sent() const noexcept {
  return tally_->bytes_sent.load(std::memory_order_relaxed);
}

void UdpWriter::set_routes(std::vector<core::Route> routes) {
  std::shared_ptr<const RouteTable> table = make_route_table(routes, variants_, side_->destinations);
  for (const core::Route& route : routes) {
    const Group* group = route.history == 0 ? nullptr : table->find(route);
    if (group != nullptr) group->outbox->hold();
  }
  {
    const std::scoped_lock lock(routes_mutex_);
    latest_routes_.swap(table);
    routes_version_.fetch_add(1, std::memory_order_release);
  }
}

/// With a number of their own, although others may be sent the same: those have had their samples.
void UdpWriter::send_history(const core::Route& to, std::vector<core::SampleHandle> samples) {
  std::shared_ptr<const RouteTable> table;
  {
    const std::scoped_lock lock(routes_mutex_);
    table = latest_routes_;
  }
  const Group* live = table->find(to);
  if (live == nullptr) return;
  auto audience = std::make_shared<Audience>(*live->audience);
  audience->variant = variants_.unused_number();
  audience->destinations = {side_->destinations.find(std::get<core::UdpAddress>(to.destination))};
  const Group only{live->mask, nullptr, audience, live->outbox};
  std::vector<std::unique_ptr<Job>> jobs;
  for (core::SampleHandle& sample : samples) {
    auto job = std::make_unique<Job>();
    if (!encode(only, *sample, *job)) continue;
    job->first.flags |= history_follows;
    job->first.history = {to.reader, samples.front()->header().sequence};
    job->sample = sample;
    job->audience = audience;
    jobs.push_back(std::move(job));
  }
  if (live->outbox->release(std::move(jobs))) side_->sender.schedule(live->outbox);
}

void UdpWriter::follow_routes() noexcept {
  if (routes_version_.load(std::memory_order_acquire) == followed_version_) return;
  std::shared_ptr<const RouteTable> before = std::move(routes_);  // goes outside the lock
  const std::scoped_lock lock(routes_mutex_);
  routes_ = latest_routes_;
  followed_version_ = routes_version_.load(std::memory_order_relaxed);
}

core::SendStatus UdpWriter::send(const core::SampleHandle& sample) noexcept {
  if (side_->sender.stopped()) return core::SendStatus::lost_port;
  follow_routes();
  core::SendStatus status = core::SendStatus::sent;
  for (const Group& group : routes_->groups) {
    if (group.gate != nullptr && !group.gate->passes()) continue;
    if (!send(group, sample)) status = core::SendStatus::dropped;
  }
  return status;
}

/// False if a destination does not get it, or if an older sample had to go for it.
bool UdpWriter::send(const Group& group, const core::SampleHandle& sample) noexcept try {
  Job& job = group.outbox->blank();
  if (!encode(group, *sample, job)) {
    tally_->dropped.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  bool lossless = true;
  if (group.outbox->idle() && send_at_once(*group.audience, job, lossless)) return lossless;
  return enqueue(group, sample, job) && lossless;
} catch (const std::bad_alloc&) {  // buffers grow with the samples that they have seen
  tally_->dropped.fetch_add(1, std::memory_order_relaxed);
  return false;
}

bool UdpWriter::encode(const Group& group, const core::SampleBuffer& sample, Job& job) {
  const bool covered = sample.mask.contains(group.mask);
  assert(covered);
  if (!covered) return false;
  const SampleHeader& header = sample.header();
  SampleState source;
  source.body = sample.data + header.body_offset;
  source.body_bytes = header.body_bytes;
  source.index = sample.index();
  source.mask = &sample.mask;
  if (!job.projection.project(source, type_.type(), group.mask)) return false;
  if (job.projection.bytes() > side_->max_sample_bytes) {
    side_->over_limit.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  const Audience& audience = *group.audience;
  job.first.label = {writer_, static_cast<std::uint32_t>(header.sequence), audience.variant};
  job.first.flags = audience.mask_words.empty() ? std::uint8_t{0} : mask_words_follow;
  if (group.gate != nullptr) {
    job.first.flags |= rate_follows;
    job.first.rate = {group.gate->min_period_us(), group.gate->ordinal()};
  }
  job.first.total = static_cast<std::uint32_t>(job.projection.bytes());
  job.first.mask = audience.mask;
  job.first.stamp_ns = header.source_stamp_ns;
  job.next_destination = 0;
  return true;
}

/// False if destinations are left, from job.next_destination on: the
/// body is not small, or the send buffer is full.
bool UdpWriter::send_at_once(const Audience& audience, Job& job, bool& lossless) noexcept {
  if (job.projection.bytes() > direct_bytes_max) return false;
  const EncodedBody body{job.first, audience.mask_words, job.projection.segments()};
  std::size_t cut_for = 0;  // bytes of the datagrams in the batch; most destinations take the same
  for (; job.next_destination < audience.destinations.size(); ++job.next_destination) {
    Destination& to = *audience.destinations[job.next_destination];
    if (const std::size_t datagram_bytes = to.datagram_bytes(); datagram_bytes != cut_for) {
      Fragmenter fragments(body, datagram_bytes);
      fragments.next(batch_);
      if (!fragments.done()) return false;
      cut_for = datagram_bytes;
    }
    if (batch_.datagrams() > to.datagrams_per_call()) return false;
    const SendOutcome outcome =
        side_->sender.try_send({to.address(), batch_.parts(), batch_.segment_bytes()});
    if (outcome == SendOutcome::would_wait) return false;
    if (outcome == SendOutcome::sent) {
      tally_->bytes_sent.fetch_add(batch_.bytes(), std::memory_order_relaxed);
    } else {
      to.note(outcome);
      tally_->dropped.fetch_add(1, std::memory_order_relaxed);
      lossless = false;
    }
  }
  return true;
}

bool UdpWriter::enqueue(const Group& group, const core::SampleHandle& sample, Job& job) {
  job.sample = sample;
  job.audience = group.audience;
  const Outbox::Posted posted = group.outbox->post();
  if (posted.was_idle) side_->sender.schedule(group.outbox);
  if (!posted.dropped_oldest) return true;
  tally_->dropped.fetch_add(1, std::memory_order_relaxed);
  side_->over_limit.fetch_add(1, std::memory_order_relaxed);
  return false;
}

}  // namespace sft::udp
