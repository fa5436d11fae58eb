#include "udp_transport/udp_writer.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>

namespace sft::udp {

namespace {
/// The maximum numbers of masks with which the publisher's thread sends a small or a large sample itself.
/// More masks would take too much of its time, especially with large samples, which fill the caches.
constexpr std::size_t small_variants_max = 4, large_variants_max = 1;

/// The maximum rate of data to a multicast group, in bytes per second as the receiving kernel counts them.
/// The rate is lower if the receive buffer of a member is small.
constexpr std::uint64_t group_bytes_per_s = 2'000'000'000;

/// The maximum size of a merged copy, relative to the maximum size of a sample. Only the average size of
/// copies is known, and a reader that requested fewer fields must get larger samples, too.
constexpr double merged_share = 0.75;

GroupKeeper::Setup groups_of(const core::WriterSpec& spec, SendSide& side,
                             std::shared_ptr<WriterTally> tally) {
  GroupKeeper::Setup setup;
  setup.writer = static_cast<std::uint32_t>(spec.id);
  setup.type = spec.type;
  setup.use = side.multicast;
  setup.report_port = side.answer_port;
  setup.queue_depth = side.queue_depth;
  setup.limits.merged_body_max = merged_share * static_cast<double>(side.max_sample_bytes);
  setup.tally = std::move(tally);
  setup.registry = &side.groups;
  setup.links = [&side](Multicast use) { return side.links.list(use); };
  setup.connect = [&side](std::uint32_t group, std::uint32_t own, std::size_t datagram_bytes) {
    DestinationLimits limits = side.limits;
    limits.datagram_bytes = datagram_bytes;
    // Members report only datagrams that come to their unicast sockets. So reports cannot limit the data to
    // a group. Instead, the receive buffers of the members limit its rate.
    limits.report_port = 0;
    limits.flow.first_bytes = std::numeric_limits<std::size_t>::max();
    limits.flow.unheard_bytes_per_s = group_bytes_per_s;
    const SocketAddress to{core::IpAddress(group), group_port};
    return std::make_shared<Destination>(to, limits, 0, [&side, own](const SocketAddress& address) {
      return side.sender.connect_group(address, {core::IpAddress(own), 0});
    });
  };
  return setup;
}

}  // namespace

UdpWriter::UdpWriter(const core::WriterSpec& spec, std::shared_ptr<SendSide> side)
    : type_(*spec.type),
      max_blocking_(spec.max_blocking),
      side_(std::move(side)),
      tally_(std::make_shared<WriterTally>(spec.max_bytes_per_s, spec.priority,
                                           ResendLimits::of_at_most(spec.resend_bytes))),
      jobs_(JobPool::make(side_->kept)),
      channels_(static_cast<std::uint32_t>(spec.id), tally_, side_->channels, side_->answer_port,
                side_->kept),
      variants_(side_->queue_depth, tally_, &channels_),
      keeper_(groups_of(spec, *side_, tally_)),
      book_(spec.book),
      sender_(spec, side_, tally_, jobs_),
      deferred_(std::make_shared<FanOut>(spec, side_, tally_, jobs_)) {
  routes_.replace(std::make_shared<RouteTable>());
  side_->writers.add(*this);
}

UdpWriter::~UdpWriter() {
  side_->writers.remove(*this);
  deferred_->finish();
}

core::NetworkWriter::Counters UdpWriter::counters() const noexcept {
  return {tally_->bytes_sent.load(std::memory_order_relaxed),
          tally_->dropped.load(std::memory_order_relaxed)};
}

std::string UdpWriter::path_trouble(core::EndpointId reader) const {
  const std::shared_ptr<const RouteTable> table = routes_.share();
  const auto lane = table->lanes_of.find(reader);
  if (lane == table->lanes_of.end()) return {};
  Destination& to = lane->second->destination();
  const bool is_mute = to.window().is_mute(std::chrono::steady_clock::now());
  return is_mute ? to.path().silence_in_words() : to.path().limit_in_words();
}

bool UdpWriter::history_sent(core::EndpointId reader) noexcept {
  return side_->sender.stopped() || (deferred_->done() && variants_.late_lane_idle(reader));
}

void UdpWriter::set_routes(std::vector<core::Route> routes) {
  asked_for_ = std::move(routes);
  make_table();
  if (variants_.concern_sender()) side_->sender.look_again();
  const Time now = std::chrono::steady_clock::now();
  keeper_.maintain(now);  // called now, so that new members of a group get its offer soon
  side_->writers.maintain_by(keeper_.next_duty(now));
}

Periodic::Time UdpWriter::maintain(Time now) {
  if (keeper_.replan(now) || channels_.any_channel_failed()) {
    make_table();
    side_->sender.look_again();
  }
  keeper_.maintain(now);
  jobs_->give_back(now);
  return keeper_.next_duty(now);
}

void UdpWriter::make_table() {
  auto table = make_route_table(type_, asked_for_, variants_, side_->destinations, &keeper_);
  if (book_ != nullptr) book_->enter(table->page);
  announce_to_receivers(*table);
  routes_.replace(std::move(table));
}

/// Requests a report from receivers that have not reported yet. So the first large sample need not be copied
/// and wait for the report.
void UdpWriter::announce_to_receivers(const RouteTable& table) {
  const auto now = std::chrono::steady_clock::now();
  for (const auto& [reader, lane] : table.lanes_of) {
    Destination& to = lane->destination();
    if (!to.window().answers()) to.mark(now);
  }
}

void UdpWriter::send_history(const core::Route& to, std::vector<core::SampleHandle> samples) {
  const std::shared_ptr<const RouteTable> table = routes_.share();
  const Audience* group = table->of_late_reader(to.reader);
  if (group == nullptr) return;
  std::vector<JobHandle> jobs;
  for (const core::SampleHandle& sample : samples) {
    JobHandle job = jobs_->take();
    if (!sender_.encode(*group, *sample, *job)) continue;
    if (!job->sample) job->sample = sample;
    jobs.push_back(std::move(job));
  }
  const std::shared_ptr<Lane>& lane = group->lanes.front();
  side_->sender.wake(lane->begin(std::move(jobs)), lane);
}

/// Makes `routes` the table in use. Samples of the previous table that the sending thread still has to send
/// are still counted. Samples of an older table must be finished before, so this function may wait for them.
void UdpWriter::turn_to(const RouteTable& routes) noexcept {
  using core::DeliveryBook;
  send_held();
  held_for_ = holds_ ? routes_.loaded() : nullptr;
  if (late_counts_ == DeliveryBook::LateCounts::to_come) deferred_->finish();
  late_counts_ = deferred_->done() ? DeliveryBook::LateCounts::none : DeliveryBook::LateCounts::to_come;
  if (book_ != nullptr) book_->turn_to(DeliveryBook::Origin::network, routes.page, late_counts_);
  in_use_ = &routes;
}

void UdpWriter::begin_sample() noexcept {
  const RouteTable* routes = routes_.load();
  if (routes != in_use_) [[unlikely]]
    turn_to(*routes);
}

core::SendStatus UdpWriter::send(const core::SampleHandle& sample) noexcept {
  begin_sample();
  return send_begun(sample, core::Reach::usual_routes);
}

core::SendStatus UdpWriter::send_begun(const core::SampleHandle& sample, core::Reach reach) noexcept {
  const std::span<const Audience> groups = in_use_->reached(reach);
  if (side_->sender.stopped()) {
    count_missed(groups);
    return core::SendStatus::lost_port;
  }
  if (BodySizes* sizes = in_use_->sizes.get())
    sizes->measure(core::state_of(*sample, type_.index_slots()), std::chrono::steady_clock::now(), holds_);
  if (!holds_) sender_.set_timeout(timeout());
  // Otherwise an audience would wait until the large body for another audience was sent.
  if (groups.size() > 1) sample->complete();
  std::size_t missed = 0;
  std::size_t own = own_variants(*sample);
  std::size_t first_left = 0;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const Audience& group = groups[i];
    if (group.gate != nullptr) {  // a gate can only be asked about the latest sample
      if (group.gate->passes()) missed += hold_or_send(group, sample);
    } else if (own > 0) {
      missed += hold_or_send(group, sample);
      first_left = i + 1;
      --own;
    }
  }
  const bool left = defer(sample, first_left, groups.size());
  return missed == 0 && left ? core::SendStatus::sent : core::SendStatus::dropped;
}

/// Returns the maximum number of masks with which the calling thread sends the sample itself.
std::size_t UdpWriter::own_variants(const core::SampleBuffer& sample) const noexcept {
  if (!deferred_->done()) return 0;  // the sample must not overtake deferred samples
  // The publisher may wait for readers, but the sending thread must not.
  if (max_blocking_.count() > 0) return SIZE_MAX;
  if (sample.capacity > direct_bytes_max) return deferred_->takes_large() ? 0 : large_variants_max;
  return holds_ ? SIZE_MAX : small_variants_max;
}

/// Holds the sample for flush() if it can be held. Otherwise sends the held samples and then this sample, so
/// that it does not overtake them.
std::size_t UdpWriter::hold_or_send(const Audience& group, const core::SampleHandle& sample) noexcept {
  using Hold = VariantSender::Hold;
  Hold hold = holds_ ? sender_.hold(group, sample) : Hold::unfit;
  if (hold == Hold::full) {
    send_held();
    hold = sender_.hold(group, sample);
  }
  if (hold == Hold::held) return 0;
  if (holds_) send_held();
  return sender_.send(group, sample);
}

void UdpWriter::hold(core::BatchTimeout timeout) noexcept {
  assert(!holds_);
  holds_ = true;
  if (timeout == core::BatchTimeout::fresh) sender_.set_timeout(max_blocking_);
  missed_ = 0;
  held_for_ = routes_.loaded();
}

std::size_t UdpWriter::flush() noexcept {
  sender_.cap_timeout(timeout());
  send_held();
  holds_ = false;
  held_for_.reset();
  return std::exchange(missed_, 0);
}

void UdpWriter::miss_begun() noexcept { count_missed(in_use_->reached(core::Reach::usual_routes)); }

void UdpWriter::count_missed(std::span<const Audience> groups) noexcept {
  for (const Audience& group : groups) {
    if (group.wants_sample()) group.tally->dropped();
  }
}

/// Passes the sample to the sending thread, for the audiences without a gate whose indices are in [first,
/// end). Returns false if an older sample was dropped for it.
bool UdpWriter::defer(const core::SampleHandle& sample, std::size_t first, std::size_t end) noexcept {
  const auto rest = std::span(routes_.loaded()->audiences).subspan(first, end - first);
  if (std::ranges::all_of(rest, [](const Audience& group) { return group.gate != nullptr; })) return true;
  send_held();
  sample->complete();
  const FanOut::Posted posted = deferred_->post({sample, routes_.loaded(), first, end});
  side_->sender.wake(posted.wake, deferred_);
  return posted.dropped == 0;
}

}  // namespace sft::udp
