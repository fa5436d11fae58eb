#include "tests/simulation/udp/world.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "tests/unit/udp/arrivals.h"
#include "tests/unit/udp/datagrams.h"

namespace sft::simulation {
namespace {
using namespace std::chrono_literals;
using udp::test::Image;
using Size = udp::ResendWindow::Size;

constexpr std::uint16_t writer_port = 7;
constexpr std::size_t datagrams_at_once = 6;
constexpr auto send_pause = 60us;
constexpr std::size_t steps_max = 200'000;

std::uint64_t log_uniform(Random& random, double most) {
  return static_cast<std::uint64_t>(std::exp(std::uniform_real_distribution<>(0, std::log(most))(random)));
}

std::size_t any_length(Random& random) {
  constexpr std::size_t lengths[] = {548, 1472, 8972};
  return lengths[from_to(random, 0, 2)];
}

const TypeSupport& image_type() { return udp::test::type_support<Image>(); }

}  // namespace

Scenario::Scenario(Random& random, bool forgers) {
  weather.loss = happens(random, 0.2) ? 0 : std::uniform_real_distribution<>(0, 0.3)(random);
  weather.repetition = happens(random, 0.5) ? 0 : 0.1;
  weather.delay = std::chrono::microseconds(log_uniform(random, 20'000));
  weather.jitter = std::chrono::microseconds(log_uniform(random, 30'000));
  if (happens(random, 0.3)) {
    weather.parted_from = Time(std::chrono::hours(1)) + std::chrono::milliseconds(from_to(random, 0, 100));
    weather.parted_until = weather.parted_from + std::chrono::milliseconds(log_uniform(random, 10'000));
  }
  datagram_bytes = any_length(random);
  sample_bytes_max = datagram_bytes > 5000 && happens(random, 0.5) ? 200'000 : 12'000;
  if (happens(random, 0.3)) first_sequence = 0xffff'ffff - from_to(random, 0, 30);
  if (happens(random, 0.2)) first_ordinal = 0xffff'ffff - from_to(random, 0, 30);
  if (happens(random, 0.1)) first_ordinal = udp::ordinal_max - from_to(random, 2000, 2030);
  tight_writer = happens(random, 0.2);
  tight_reader = happens(random, 0.2);
  crashes = happens(random, 0.15);
  change = happens(random, 0.5) ? 0.1 : 0;
  regroup = happens(random, 0.5) ? 0.15 : 0;
  span = happens(random, 0.3) ? 0.2 : 0;
  readers_lag = happens(random, 0.3);
  detour = happens(random, 0.3) ? 0.2 : 0;
  if (happens(random, 0.2)) {
    stalled_from = Time(std::chrono::hours(1)) + std::chrono::milliseconds(from_to(random, 0, 100));
    stalled_until = stalled_from + std::chrono::milliseconds(log_uniform(random, 10'000));
  }
  if (forgers) beset(random);
  resend.repair_bytes_per_s = 20'000'000;
  reassembly.channel.ack_bytes = from_to(random, 5'000, 125'000);
  receive_buffer_bytes += log_uniform(random, 8e6);
  if (tight_writer) {
    resend.samples = from_to(random, 2, 12);
    resend.bytes = from_to(random, 20'000, 200'000);
  }
  if (!tight_reader) return;
  reassembly.channel.samples = from_to(random, 4, 16);
  reassembly.channel.held_bytes = from_to(random, 20'000, 200'000);
  reassembly.channel.awaited_bytes = 2 * reassembly.channel.held_bytes;
}

/// Nothing else keeps a sample from coming, and it goes on for long enough.
void Scenario::beset(Random& random) {
  weather.forged = std::uniform_real_distribution<>(0.01, 0.5)(random);
  weather.forged_until = Time(std::chrono::hours(1)) + 200ms;
  weather.loss = std::min(weather.loss, 0.1);
  weather.parted_until = {};
  stalled_from = Time::max();
  first_ordinal = 1;
  change = 0;
  tight_writer = tight_reader = crashes = readers_lag = false;
  sample_bytes_max = std::min<std::size_t>(sample_bytes_max, 12'000);
  samples = 900;
}

const std::vector<FieldMask>& World::masks() {
  static const std::vector<FieldMask> all = {udp::test::fields<Image>("*"), udp::test::fields<Image>("data"),
                                             udp::test::fields<Image>("stamp, width")};
  return all;
}

World::World(std::uint64_t seed, bool forgers)
    : random_(seed),
      forgers_(forgers),
      scenario_(random_, forgers),
      network_(scenario_.weather, random_),
      send_at_(now_),
      sequence_(scenario_.first_sequence),
      datagram_bytes_(scenario_.datagram_bytes),
      publish_at_(now_) {
  if (scenario_.crashes) crash_at_ = now_ + std::chrono::milliseconds(from_to(random_, 0, 100));
  start_process();
  open_channel();
}

void World::open_channel() {
  const std::uint64_t first = channel_ == 0 ? scenario_.first_ordinal : 1;
  oldest_kept_ = first;
  window_ = std::make_unique<udp::ResendWindow>(static_cast<std::uint32_t>(writer_id), ++channel_,
                                                scenario_.resend, first);
  flow_ = std::make_unique<udp::FlowWindow>(channel_, udp::FlowLimits{});
  leaving_.clear();
}

void World::start_process() {
  reassembly_ = std::make_unique<udp::Reassembly>(scenario_.reassembly, memory_);
  directory_ = std::make_unique<udp::SubscriptionDirectory>();
  shares_ = std::make_unique<udp::ReceiveShares>(scenario_.receive_buffer_bytes);
  readers_.clear();
  came_at_once_.clear();
  unwanted_.clear();
  lost_ = 0;
  for (auto& [number, channel] : channels_) channel = {.sent = std::move(channel.sent)};
  for (core::EndpointId id = 1; id <= from_to(random_, 1, 3); ++id) {
    const Mask mask = from_to(random_, 0, 2);
    readers_.push_back({.id = id + 100 * channel_,
                        .inbox = std::make_shared<udp::Inbox>(1, nullptr),
                        .requests = core::AcceptedRequests({masks()[mask]}, true),
                        .served = mask});
    const Reader& reader = readers_.back();
    directory_->add(reader.id, reader.inbox, image_type());
    directory_->accept(*reader.inbox, reader.requests.all());
    const core::Source source{.writer = writer_id, .reliable = true, .waits = scenario_.readers_lag};
    if (!directory_->connect(*reader.inbox, source)) fail("a reader is not connected");
  }
  follow();
}

/// Gives the process what its readers want by now.
void World::follow() {
  subscriptions_ = directory_->enter();
  reassembly_->set_streams(subscriptions_->streams);
  std::vector<core::EndpointId> ids;
  for (const Reader& reader : readers_) ids.push_back(reader.id);
  reassembly_->window(0)->set_readers(ids);
  for (const udp::Subscriber& subscriber : subscriptions_->subscribers[0])
    reassembly_->window(0)->heard(subscriber.reader, subscriber.heard_request());
}

/// The process's successor is served by another channel, once the writer has noticed.
void World::crash() {
  crash_at_ = Time::max();
  reassembly_.reset();
  readers_.clear();
  look_again_at_ = Time::max();
  back_at_ = now_ + std::chrono::milliseconds(from_to(random_, 0, 50));
}

void World::publish() {
  std::set<Mask> served;
  for (const Reader& reader : readers_) served.insert(reader.served);
  const bool is_span = served.size() == 1 && !group_ && happens(random_, scenario_.span);
  const double bytes_max = is_span ? 200 : static_cast<double>(scenario_.sample_bytes_max);
  std::vector<Image> images;
  for (std::size_t left = is_span ? from_to(random_, 2, 40) : 1; left > 0; --left) {
    const auto seed = static_cast<std::uint32_t>((sequence_ + images.size()) * 7);
    images.push_back(udp::test::make_image(log_uniform(random_, bytes_max), seed));
  }
  FieldMask all = image_type().none();
  for (const Mask mask : served) all |= masks()[mask];
  if (group_) {
    publish_to_group(images.front(), all);
  } else {
    for (const Mask mask : served) keep(encode(images, masks()[mask], static_cast<std::uint16_t>(mask)));
  }
  if (forgers_ && now_ < scenario_.weather.forged_until + 1s) first_owed_ = sequence_ + images.size();
  for (Image& image : images) {
    for (Reader& reader : readers_)
      reader.to_get.push_back({sequence_, (group_ ? all : masks()[reader.served]).hash()});
    images_.emplace(sequence_++, std::move(image));
  }
  const bool is_last = ++published_ == scenario_.samples;
  publish_at_ = is_last ? Time::max() : now_ + std::chrono::microseconds(log_uniform(random_, 20'000));
  send_at_ = std::min(send_at_, now_);
  if (happens(random_, scenario_.change)) change_a_mask();
  if (happens(random_, scenario_.regroup)) regroup();
  if (happens(random_, scenario_.detour)) datagram_bytes_ = any_length(random_);
}

/// Once, under all masks of the process.
void World::publish_to_group(const Image& image, const FieldMask& all) {
  std::size_t served = 0;
  for (const Reader& reader : readers_) served |= std::size_t{1} << reader.served;
  if (served == 0) return;
  udp::JobHandle job = encode({&image, 1}, all, static_cast<std::uint16_t>(100 + served));
  job->first.flags |= udp::merged_masks;
  const udp::ResendWindow::Kept kept = keep(job, group_->membership.hears());
  const std::uint64_t ordinal = ++group_->last_ordinal;
  if (!group_->ahead) group_->ahead = static_cast<std::int64_t>(kept.ordinal - ordinal);
  group_->membership.sent(now_);
  job->first.flags |= udp::group_follows;
  job->first.group = {group_->number, static_cast<std::uint32_t>(sequence_ >> 32), ordinal};
  const Time at_once = leaving_.empty() ? now_ : leaving_.back().at;
  const std::chrono::microseconds waits(happens(random_, 0.5) ? 0 : log_uniform(random_, 20'000));
  const bool lost = group_->deaf || happens(random_, 0.02);
  leaving_.push_back({std::max(at_once, now_ + waits), job, kept.elsewhere ? kept.ordinal : 0, lost});
  send_to_group();
}

/// Sends the datagrams that have waited long enough. The rest of their samples may go to another group by
/// then, or to none.
void World::send_to_group() {
  while (!leaving_.empty() && leaving_.front().at <= now_) {
    const Leaving leaving = std::move(leaving_.front());
    leaving_.pop_front();
    if (!leaving.lost) send_to_group(leaving.job);
    if (leaving.in_channel != 0) window_->departed(leaving.in_channel, now_);
  }
}

void World::send_to_group(const udp::JobHandle& job) {
  udp::Fragmenter fragments(job->body(), datagram_bytes_);
  std::vector<Bytes> datagrams;
  while (!fragments.done()) {
    udp::Batch batch;
    fragments.next(batch, udp::batch_bytes_max, 1);
    udp::test::append_datagrams(batch.parts(), batch.segment_bytes(), datagrams);
  }
  for (Bytes& datagram : datagrams) network_.send(Network::Side::reader, std::move(datagram), now_);
}

/// Another one, none, or what it was loses its way.
void World::regroup() {
  if (group_ && happens(random_, 0.3)) {
    group_->deaf = !group_->deaf;
  } else if (group_ && happens(random_, 0.3)) {
    group_.reset();
  } else {
    group_.emplace(Group{.number = ++last_group_, .deaf = happens(random_, 0.1)});
  }
}

void World::offer_group() {
  if (!group_ || !group_->ahead) return;
  group_->membership.look(now_);
  if (!group_->membership.offer_due(now_)) return;
  const udp::GroupOffer offer{.writer = static_cast<std::uint32_t>(writer_id),
                              .group = group_->number,
                              .port = writer_port,
                              .address = udp::private_groups + 1,
                              .channel = channel_,
                              .ahead = *group_->ahead};
  Bytes bytes(udp::group_offer_bytes);
  udp::encode(offer, bytes.data());
  network_.send(Network::Side::reader, std::move(bytes), now_);
}

void World::hear_report(const udp::GroupReport& report) {
  if (!group_ || report.group != group_->number) return;
  if (forgers_ && report.heard > group_->last_ordinal) return;
  if (report.heard > group_->last_ordinal) return fail("a report of what was never sent");
  if (report.heard == 0) return group_->membership.refused(group_->last_ordinal, now_);
  group_->membership.reported(report.heard, now_);
}

udp::ResendWindow::Kept World::keep(const udp::JobHandle& job, bool elsewhere) {
  const udp::ResendWindow::Kept kept = window_->keep(job, job->first, elsewhere);
  const std::uint64_t end = window_->parting().end;
  auto& sent = channels_[channel_].sent;
  for (std::uint64_t i = 0; i < job->samples(); ++i)
    sent.emplace(end - job->samples() + i, Variant{job->sequence + i, job->first.mask});
  const std::uint64_t oldest = end - window_->kept();
  for (std::uint64_t i = oldest_kept_; i < oldest; ++i) not_kept_.insert(sent.at(i).sequence);
  oldest_kept_ = oldest;
  return kept;
}

/// Several are a pack.
udp::JobHandle World::encode(std::span<const Image> images, const FieldMask& mask, std::uint16_t variant) {
  const FieldMask all = image_type().full();
  udp::JobHandle job = jobs_->take();
  job->mask = std::make_shared<udp::WireMask>(udp::WireMask{variant, mask.hash(), {}});
  job->sequence = sequence_;
  job->first.label = {static_cast<std::uint32_t>(writer_id), static_cast<std::uint32_t>(sequence_), variant};
  job->first.flags = 0;
  job->first.mask = job->mask->mask;
  for (const Image& image : images) {
    core::SampleHandle sample = memory_->take(udp::test::sample_bytes(image, all));
    udp::test::fill(*sample, image, all, writer_id, sequence_);
    project(*job, sample, mask, images.size() > 1);
  }
  if (images.size() > 1) job->seal();
  return job;
}

void World::project(udp::Job& job, const core::SampleHandle& sample, const FieldMask& mask, bool packed) {
  job.projection.project(core::state_of(*sample, image_type().slots()), image_type().type(), mask);
  if (packed) return job.pack(job.projection.segments());
  job.first.total = static_cast<std::uint32_t>(job.projection.bytes());
  if (happens(random_, 0.5)) {
    job.copy_body();
  } else {
    job.sample = sample;
  }
}

/// The reader takes both from now on, and the writer gets to know later.
void World::change_a_mask() {
  if (readers_.empty()) return;
  Reader& reader = readers_[from_to(random_, 0, readers_.size() - 1)];
  const Mask mask = from_to(random_, 0, 2);
  if (reader.requests.latest().mask == masks()[mask]) return;
  reader.requests.asks_for({masks()[mask]}, now_);
  directory_->accept(*reader.inbox, reader.requests.all());
  follow();
  const Time after = reader.under_way.empty() ? now_ : reader.under_way.back().first;
  const auto delay = std::chrono::microseconds(log_uniform(random_, 50'000));
  reader.under_way.emplace_back(std::max(after, now_ + delay), mask);
}

void World::learn_of_masks() {
  for (Reader& reader : readers_) {
    while (!reader.under_way.empty() && reader.under_way.front().first <= now_) {
      reader.served = reader.under_way.front().second;
      reader.under_way.pop_front();
    }
    if (!reader.requests.look(now_)) continue;
    directory_->accept(*reader.inbox, reader.requests.all());
    follow();
  }
}

void World::send_some() {
  send_at_ = Time::max();
  if (now_ >= scenario_.stalled_from && now_ < scenario_.stalled_until) {
    send_at_ = scenario_.stalled_until;
  } else {
    send_some(Size::small);
    send_some(Size::large);
  }
  send_heartbeat();
}

void World::send_some(Size size) {
  std::optional<Sending>& sending = sending_[static_cast<std::size_t>(size)];
  for (std::size_t i = 0; i < datagrams_at_once; ++i) {
    if (!sending) {
      std::optional<udp::ResendWindow::Piece> piece = window_->next(size, now_);
      if (!piece) return;
      const udp::Fragmenter fragments(piece->body(), datagram_bytes_, piece->range);
      sending.emplace(Sending{std::move(*piece), fragments});
    }
    if (!may_send(size)) return;
    udp::Batch batch;
    std::vector<Bytes> datagrams;
    sending->fragments.next(batch, udp::batch_bytes_max, 1);
    udp::test::append_datagrams(batch.parts(), batch.segment_bytes(), datagrams);
    network_.send(Network::Side::reader, std::move(datagrams.front()), now_);
    flow_->sent(batch.bytes(), 1, now_);
    send_mark();
    if (!sending->fragments.done()) continue;
    if (happens(random_, 0.02)) {  // from anywhere, since all of it has left
      if (sending->piece.job->samples() == 1)
        sending->piece.range.begin = random_() % sending->piece.first.total;
      window_->put_back(sending->piece);
    } else {
      window_->finished(sending->piece, now_);
    }
    sending.reset();
  }
  send_at_ = now_ + send_pause;
}

bool World::may_send(Size size) {
  using FlowSize = udp::FlowWindow::Size;
  if (flow_->room(size == Size::small ? FlowSize::small : FlowSize::large, now_) > 0) return true;
  send_mark();
  send_at_ = std::min(send_at_, std::max(flow_->next_ready(now_), now_ + 1us));
  return false;
}

void World::send_mark() {
  std::optional<udp::FlowMark> mark = flow_->mark(now_);
  if (!mark) return;
  mark->port = writer_port;
  Bytes bytes(udp::mark_bytes);
  udp::encode(*mark, bytes.data());
  network_.send(Network::Side::reader, std::move(bytes), now_);
}

void World::hear(const Bytes& bytes) {
  if (const auto ack = udp::parse_ack(bytes)) {
    window_->hear(*ack, now_);
    oldest_kept_ = window_->parting().first - window_->kept();
  } else if (const auto report = udp::parse_report(bytes)) {
    if (!flow_->hear(*report, now_)) return;
  } else if (const auto group_report = udp::parse_group_report(bytes)) {
    return hear_report(*group_report);
  }
  send_at_ = std::min(send_at_, now_);
}

void World::send_heartbeat() {
  std::optional<udp::Heartbeat> heartbeat = window_->heartbeat(now_);
  if (!heartbeat) return;
  heartbeat->port = writer_port;
  Bytes bytes(udp::heartbeat_bytes);
  udp::encode(*heartbeat, bytes.data());
  network_.send(Network::Side::reader, std::move(bytes), now_);
}

void World::receive(const Bytes& bytes) {
  if (reassembly_ == nullptr) return;
  const udp::ArrivalTime now{now_, 1};
  if (udp::kind_of(bytes) == udp::DatagramKind::mark) return report(bytes);
  if (udp::kind_of(bytes) == udp::DatagramKind::group_offer)
    return static_cast<void>(udp::test::accept(*reassembly_, bytes, now));
  shares_->count({});
  const auto before = reassembly_->window(0)->mark();
  const std::optional<udp::Heartbeat> heartbeat = udp::parse_heartbeat(bytes);
  if (heartbeat) {
    udp::test::accept(*reassembly_, bytes, now);
  } else {
    const std::uint64_t unwanted_before = reassembly_->counters().unknown;
    const udp::Arrival arrival = udp::test::accept(*reassembly_, bytes, now);
    if (reassembly_->counters().unknown > unwanted_before) note_unwanted(bytes);
    if (arrival.sample) take_at_once(*arrival.sample);
    for (const core::SampleHandle& sample : arrival.packed) take_at_once(*sample);
  }
  note_channel(before, heartbeat);
  hand_over();
  answer();
}

/// With the first word of a channel everything that is missing of the former channel is lost.
void World::note_channel(const std::optional<udp::ArrivalWindow::Mark>& before,
                         const std::optional<udp::Heartbeat>& heartbeat) {
  const auto mark = reassembly_->window(0)->mark();
  if (!mark) return;
  Channel& channel = channels_[mark->channel];
  if (before && before->channel != mark->channel) {
    Channel& last = channels_[before->channel];
    last.gone_before = before->end;
    channel.base = last.base + before->end - 1;
  }
  const bool is_of_channel = heartbeat && heartbeat->channel == mark->channel;
  // A heartbeat is a word of the channel even before its first sample: what is sent after it can be lost.
  if (!channel.known_from && (is_of_channel || mark->end > 1))
    channel.known_from = heartbeat ? heartbeat->first : 1;
  if (is_of_channel) channel.gone_before = std::max(channel.gone_before, heartbeat->first);
}

void World::report(const Bytes& bytes) {
  const auto mark = udp::parse_mark(bytes);
  if (!mark && forgers_) return;
  if (!mark) return fail("a mark is malformed");
  Bytes report(udp::report_bytes);
  udp::encode(shares_->answer(*mark, {}, now_), report.data());
  network_.send(Network::Side::writer, std::move(report), now_);
}

/// Takes a sample as a best-effort reader does.
void World::take_at_once(const core::SampleBuffer& sample) {
  const std::string which = "sample " + std::to_string(sample.sequence);
  if (forgers_) return;
  if (is_sound(sample, which) && !came_at_once_.insert({sample.sequence, sample.mask.hash()}).second)
    fail(which + " comes twice");
}

/// Notes a datagram that comes for a former process.
void World::note_unwanted(const Bytes& bytes) {
  if (forgers_) return;
  const auto datagram = udp::parse(bytes);
  if (!datagram) return fail("what makes no sense is taken for unwanted");
  const std::uint64_t sequence = udp::widen_sequence(sequence_, datagram->label().sequence);
  for (std::uint64_t i = 0; i < std::max<std::uint64_t>(datagram->samples, 1); ++i)
    unwanted_.insert({sequence + i, datagram->first.mask});
}

void World::answer() {
  reassembly_->answer(now_, [&](const udp::SocketAddress& to, const udp::Ack& ack) {
    if (to.port != writer_port && forgers_) return;
    if (to.port != writer_port) fail("an ack goes elsewhere");
    Bytes bytes(ack.bytes());
    udp::encode(ack, bytes.data());
    network_.send(Network::Side::writer, std::move(bytes), now_);
  });
  reassembly_->report_groups([&](const udp::SocketAddress&, const udp::GroupReport& report) {
    Bytes bytes(udp::group_report_bytes);
    udp::encode(report, bytes.data());
    network_.send(Network::Side::writer, std::move(bytes), now_);
  });
  reassembly_->expire(now_);
}

/// Returns the room in the queue of a reader whose queue is now and then full.
std::size_t World::room_now() {
  const bool lags = scenario_.readers_lag && !reassembly_->window(0)->overtakes();
  return lags ? from_to(random_, 0, 2) : SIZE_MAX;
}

void World::hand_over() {
  udp::ArrivalWindow& arrivals = *reassembly_->window(0);
  for (std::size_t i = 0; i < readers_.size(); ++i) {
    Reader& reader = readers_[i];
    const udp::Subscriber& subscriber = subscriptions_->subscribers[0][i];
    const auto accepts = [&](const core::SampleBuffer& sample, std::uint64_t request) {
      return subscriber.accepts(sample, request);
    };
    for (std::size_t room = room_now(); room > 0; --room) {
      const core::SampleHandle sample = arrivals.next(reader.id, accepts);
      if (!sample) break;
      get(reader, *sample);
    }
  }
  arrivals.release();
  look_again_at_ =
      arrivals.holds_back() ? now_ + std::chrono::microseconds(log_uniform(random_, 20'000)) : Time::max();
}

void World::get(Reader& reader, const core::SampleBuffer& sample) {
  const std::string which =
      "sample " + std::to_string(sample.sequence) + " of reader " + std::to_string(reader.id);
  if (forgers_ && sample.sequence < first_owed_) return;
  if (forgers_ && !images_.contains(sample.sequence)) return;
  if (!is_sound(sample, which)) return;
  if (forgers_) return static_cast<void>(reader.got.insert(sample.sequence));
  if (sample.sequence == reader.last) {
    // While its mask changes, a sample can come under both, for it and for another.
    const bool changes = reader.took_others || reader.requests.all().size() > 1;
    if (!changes || !reader.last_masks.insert(sample.mask.hash()).second) fail(which + " comes twice");
    return;
  }
  if (sample.sequence < reader.last) return fail(which + " comes after " + std::to_string(reader.last));
  reader.last = sample.sequence;
  reader.last_masks = {sample.mask.hash()};
  reader.took_others = reader.requests.all().size() > 1;
  reader.got.insert(sample.sequence);
}

Time World::next_event() const {
  Time next =
      std::min({network_.next(), publish_at_, crash_at_, back_at_, send_at_, window_->next_look(now_)});
  if (!leaving_.empty()) next = std::min(next, leaving_.front().at);
  for (const Reader& reader : readers_) {
    if (!reader.under_way.empty()) next = std::min(next, reader.under_way.front().first);
  }
  if (reassembly_ == nullptr) return next;
  return std::min(
      {next, look_again_at_, reassembly_->next_answer(), reassembly_->next_expiry().value_or(Time::max())});
}

bool World::step() {
  const Time next = next_event();
  if (next == Time::max()) return false;
  now_ = std::max(now_, next);
  while (network_.next() <= now_) {
    const Network::Datagram datagram = network_.take();
    if (datagram.to == Network::Side::reader) {
      receive(datagram.bytes);
    } else {
      hear(datagram.bytes);
    }
  }
  if (crash_at_ <= now_) crash();
  if (back_at_ <= now_) {
    back_at_ = Time::max();
    open_channel();
    for (auto& sending : sending_) sending.reset();
    start_process();
    if (group_) group_.emplace(Group{.number = ++last_group_});
  }
  learn_of_masks();
  send_to_group();
  if (publish_at_ <= now_) publish();
  if (send_at_ <= now_ || window_->next_look(now_) <= now_) send_some();
  offer_group();
  if (look_again_at_ <= now_) hand_over();
  if (reassembly_ != nullptr) answer();
  check_limits();
  return failure_.empty();
}

std::string World::run() {
  for (std::size_t steps = 0; step(); ++steps) {
    if (steps == steps_max) fail("it does not come to rest");
  }
  if (failure_.empty()) check_end();
  return failure_;
}

void World::fail(const std::string& what) {
  if (!failure_.empty()) return;
  failure_ = what + ", after " + std::to_string((now_ - Time(std::chrono::hours(1))) / 1us) + " us";
}

}  // namespace sft::simulation
