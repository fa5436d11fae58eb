#include "udp_transport/udp_writer.h"

#include <algorithm>
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
      jobs_(JobPool::make()) {
  routes_.store(std::make_shared<RouteTable>());
}

std::uint64_t UdpWriter::bytes_sent() const noexcept {
  return tally_->bytes_sent.load(std::memory_order_relaxed);
}

std::uint64_t UdpWriter::dropped() const noexcept { return tally_->dropped.load(std::memory_order_relaxed); }

bool UdpWriter::history_sent() const noexcept {
  return side_->sender.stopped() || tally_->history_waiting.load(std::memory_order_relaxed) == 0;
}

void UdpWriter::set_routes(std::vector<core::Route> routes) {
  auto table = make_route_table(type_.type(), routes, variants_, side_->destinations);
  for (const core::Route& route : routes) {
    const Group* group = route.history == 0 ? nullptr : table->find(route);
    if (group != nullptr) lane_of(*group, route)->hold();
  }
  if (book_ != nullptr) book_->enter(table->page);
  routes_.store(std::move(table));
  side_->sender.look_again();
}

/// With a number of their own, although others may be sent the same: those have had their samples.
void UdpWriter::send_history(const core::Route& to, std::vector<core::SampleHandle> samples) {
  const std::shared_ptr<const RouteTable> table = routes_.share();
  const Group* live = table->find(to);
  if (live == nullptr) return;
  auto wire = std::make_shared<WireMask>(*live->wire);
  wire->variant = variants_.unused_number();
  std::vector<JobHandle> jobs;
  for (const core::SampleHandle& sample : samples) {
    JobHandle job = jobs_->take();
    if (!encode(live->plan, wire, *sample, *job)) continue;
    job->first.flags |= history_follows;
    job->first.history = {to.reader, samples.front()->sequence};
    job->sample = sample;
    jobs.push_back(std::move(job));
  }
  const std::shared_ptr<Lane> lane = lane_of(*live, to);
  if (lane->release(std::move(jobs))) side_->sender.schedule(lane);
}

/// That leads to one of those whom the group serves.
std::shared_ptr<Lane> UdpWriter::lane_of(const Group& group, const core::Route& route) {
  const auto destination = side_->destinations.find(std::get<core::UdpAddress>(route.destination));
  return *std::find_if(group.lanes.begin(), group.lanes.end(), [&](const std::shared_ptr<Lane>& lane) {
    return &lane->destination() == destination.get();
  });
}

void UdpWriter::turn_to(const RouteTable& routes) noexcept {
  if (book_ != nullptr) book_->turn_to(core::DeliveryBook::Teller::network, routes.page);
  in_use_ = &routes;
}

void UdpWriter::begin() noexcept {
  const RouteTable* routes = routes_.load();
  if (routes != in_use_) [[unlikely]]
    turn_to(*routes);
  begun_ = true;
}

const RouteTable& UdpWriter::routes_of_sample() noexcept {
  if (!begun_) begin();
  begun_ = false;
  return *in_use_;
}

core::SendStatus UdpWriter::send(const core::SampleHandle& sample) noexcept {
  if (side_->sender.stopped()) {
    miss();
    return core::SendStatus::lost_port;
  }
  core::SendStatus status = core::SendStatus::sent;
  for (const Group& group : routes_of_sample().groups) {
    if (!group.wants_sample()) continue;
    if (!send(group, sample)) status = core::SendStatus::dropped;
  }
  return status;
}

void UdpWriter::miss() noexcept {
  for (const Group& group : routes_of_sample().groups) {
    if (group.wants_sample()) group.tally->dropped();
  }
}

/// False if a destination does not get it, or if an older sample had to go for it.
bool UdpWriter::send(const Group& group, const core::SampleHandle& sample) noexcept try {
  if (!blank_) blank_ = jobs_->take();
  Job& job = *blank_;
  if (!encode(group.plan, group.wire, *sample, job)) {
    group.tally->dropped();
    return false;
  }
  if (group.gate != nullptr) {
    job.first.flags |= rate_follows;
    job.first.rate = {group.gate->min_period_us(), group.gate->ordinal()};
  }
  cut_for_ = 0;
  bool lossless = true;
  for (const std::shared_ptr<Lane>& lane : group.lanes) {
    const SendOutcome outcome =
        lane->idle() ? try_send(lane->destination(), job.body()) : SendOutcome::would_wait;
    if (outcome == SendOutcome::would_wait) {
      if (!job.sample) job.sample = sample;
      lossless &= enqueue(lane);
    } else if (outcome != SendOutcome::sent) {
      lane->losses()->lost(job.first.total, sample->whole_bytes);
      lossless = false;
    }
  }
  group.tally->sent(job.first.total, sample->whole_bytes);
  if (job.sample) blank_ = {};
  return lossless;
} catch (const std::bad_alloc&) {  // buffers grow with the samples that they have seen
  group.tally->dropped();
  blank_ = {};
  return false;
}

bool UdpWriter::encode(const ProjectionPlan& plan, const std::shared_ptr<const WireMask>& wire,
                       const core::SampleBuffer& sample, Job& job) {
  assert(sample.mask.contains(plan.mask()));
  const SampleState source = core::state_of(sample, type_.slots());
  if (!job.projection.project(source, plan)) return false;
  if (job.projection.bytes() > side_->max_sample_bytes) {
    side_->over_limit.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  job.mask = wire;
  job.first.label = {writer_, static_cast<std::uint32_t>(sample.sequence), wire->variant};
  job.first.flags = wire->words.empty() ? std::uint8_t{0} : mask_words_follow;
  job.first.total = static_cast<std::uint32_t>(job.projection.bytes());
  job.first.mask = wire->mask;
  job.first.stamp_ns = sample.source_stamp_ns;
  return true;
}

/// `would_wait` where it is for the sending thread: the body is not small, or the send buffer is full.
SendOutcome UdpWriter::try_send(Destination& to, const EncodedBody& body) {
  if (body.first.total > direct_bytes_max) return SendOutcome::would_wait;
  // Most destinations take datagrams of the same length: they are cut once.
  if (const std::size_t datagram_bytes = to.datagram_bytes(); datagram_bytes != cut_for_) {
    Fragmenter fragments(body, datagram_bytes);
    fragments.next(batch_);
    cut_for_ = fragments.done() ? datagram_bytes : 0;
    if (!fragments.done()) return SendOutcome::would_wait;
  }
  if (batch_.datagrams() > to.datagrams_per_call()) return SendOutcome::would_wait;
  const OutgoingBatch batch{batch_.parts(), batch_.segment_bytes()};
  const SendOutcome outcome = to.connection().try_send({&batch, 1}).outcome;
  if (outcome == SendOutcome::sent) {
    tally_->bytes_sent.fetch_add(batch_.bytes(), std::memory_order_relaxed);
  } else if (outcome != SendOutcome::would_wait) {
    to.note(outcome);
  }
  return outcome;
}

/// False if an older sample had to go for it.
bool UdpWriter::enqueue(const std::shared_ptr<Lane>& lane) {
  const Lane::Posted posted = lane->post(blank_);
  if (posted.was_idle) side_->sender.schedule(lane);
  if (posted.dropped_oldest) side_->over_limit.fetch_add(1, std::memory_order_relaxed);
  return !posted.dropped_oldest;
}

}  // namespace sft::udp
