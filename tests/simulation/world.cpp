#include "world.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "tests/udp/datagrams.h"

namespace sft::simulation {

namespace {

using namespace std::chrono_literals;
using udp::test::Image;
using Size = udp::ResendWindow::Size;

constexpr core::EndpointId writer_id = 0x7'0000'0001;
constexpr std::uint16_t writer_port = 7;
constexpr std::size_t datagrams_at_once = 6;
constexpr auto send_pause = 60us;
constexpr std::size_t steps_max = 200'000;

std::uint64_t log_uniform(Random& random, double most) {
  return static_cast<std::uint64_t>(std::exp(std::uniform_real_distribution<>(0, std::log(most))(random)));
}

const TypeSupport& image_type() { return udp::test::type_support<Image>(); }

}  // namespace

Scenario::Scenario(Random& random) {
  weather.loss = happens(random, 0.2) ? 0 : std::uniform_real_distribution<>(0, 0.3)(random);
  weather.repetition = happens(random, 0.5) ? 0 : 0.1;
  weather.delay = std::chrono::microseconds(log_uniform(random, 20'000));
  weather.jitter = std::chrono::microseconds(log_uniform(random, 30'000));
  if (happens(random, 0.3)) {
    weather.parted_from = Time(std::chrono::hours(1)) + std::chrono::milliseconds(from_to(random, 0, 100));
    weather.parted_until = weather.parted_from + std::chrono::milliseconds(log_uniform(random, 10'000));
  }
  constexpr std::size_t lengths[] = {548, 1472, 8972};
  datagram_bytes = lengths[from_to(random, 0, 2)];
  sample_bytes_max = datagram_bytes > 5000 && happens(random, 0.5) ? 200'000 : 12'000;
  if (happens(random, 0.3)) first_sequence = 0xffff'ffff - from_to(random, 0, 30);
  if (happens(random, 0.2)) first_ordinal = 0xffff'ffff - from_to(random, 0, 30);
  tight_writer = happens(random, 0.2);
  tight_reader = happens(random, 0.2);
  crashes = happens(random, 0.15);
  change = happens(random, 0.5) ? 0.1 : 0;
  regroup = happens(random, 0.5) ? 0.15 : 0;
  span = happens(random, 0.3) ? 0.2 : 0;
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
}

const std::vector<FieldMask>& World::masks() {
  static const std::vector<FieldMask> all = {udp::test::fields<Image>("*"), udp::test::fields<Image>("data"),
                                             udp::test::fields<Image>("stamp, width")};
  return all;
}

bool World::Reader::accepts(const core::SampleBuffer& sample) const {
  return std::ranges::any_of(accepted, [&](Mask mask) {
    return sample.merged ? sample.mask.contains(masks()[mask]) : masks()[mask] == sample.mask;
  });
}

World::World(std::uint64_t seed)
    : random_(seed),
      scenario_(random_),
      network_(scenario_.weather, random_),
      send_at_(now_),
      sequence_(scenario_.first_sequence),
      publish_at_(now_) {
  if (scenario_.crashes) crash_at_ = now_ + std::chrono::milliseconds(from_to(random_, 0, 100));
  start_process();
  open_channel();
}

void World::open_channel() {
  const std::uint64_t first = channel_ == 0 ? scenario_.first_ordinal : 1;
  sequences_.clear();
  oldest_kept_ = first;
  window_ = std::make_unique<udp::ResendWindow>(static_cast<std::uint32_t>(writer_id), ++channel_,
                                                scenario_.resend, first);
  flow_ = std::make_unique<udp::FlowWindow>(channel_, udp::FlowLimits{});
  leaving_.clear();
}

void World::start_process() {
  reassembly_ = std::make_unique<udp::Reassembly>(scenario_.reassembly, memory_);
  udp::Stream stream{.writer = writer_id, .type = &image_type(), .masks = masks(), .reliable = true};
  reassembly_->set_streams({&stream, 1});
  shares_ = std::make_unique<udp::ReceiveShares>(scenario_.receive_buffer_bytes);
  readers_.clear();
  came_at_once_.clear();
  for (core::EndpointId id = 1; id <= from_to(random_, 1, 3); ++id) {
    const Mask mask = from_to(random_, 0, 2);
    readers_.push_back({.id = id + 100 * channel_, .accepted = {mask}, .served = mask});
  }
  std::vector<core::EndpointId> ids;
  for (const Reader& reader : readers_) ids.push_back(reader.id);
  reassembly_->window(0)->set_readers(ids);
}

/// Its successor is served by another channel, once the writer has noticed.
void World::crash() {
  crash_at_ = Time::max();
  reassembly_.reset();
  readers_.clear();
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
  if (group_) {
    publish_to_group(images.front());
  } else {
    for (const Mask mask : served) keep(encode(images, masks()[mask], static_cast<std::uint16_t>(mask)));
  }
  for (Image& image : images) {
    for (Reader& reader : readers_) reader.to_get.push_back(sequence_);
    images_.emplace(sequence_++, std::move(image));
  }
  const bool is_last = ++published_ == scenario_.samples;
  publish_at_ = is_last ? Time::max() : now_ + std::chrono::microseconds(log_uniform(random_, 20'000));
  send_at_ = std::min(send_at_, now_);
  if (happens(random_, scenario_.change)) change_a_mask();
  if (happens(random_, scenario_.regroup)) regroup();
}

/// Once, under all masks of the process.
void World::publish_to_group(const Image& image) {
  std::size_t served = 0;
  FieldMask all = image_type().none();
  for (const Reader& reader : readers_) {
    all |= masks()[reader.served];
    served |= std::size_t{1} << reader.served;
  }
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

/// What has waited long enough. The rest of its samples may go to another group by then, or to none.
void World::send_to_group() {
  while (!leaving_.empty() && leaving_.front().at <= now_) {
    const Leaving leaving = std::move(leaving_.front());
    leaving_.pop_front();
    if (!leaving.lost) send_to_group(leaving.job);
    if (leaving.in_channel != 0) window_->left(leaving.in_channel, now_);
  }
}

void World::send_to_group(const udp::JobHandle& job) {
  udp::Fragmenter fragments(job->body(), scenario_.datagram_bytes);
  std::vector<Bytes> datagrams;
  while (!fragments.done()) {
    udp::Batch batch;
    fragments.next(batch, udp::batch_bytes_max, 1);
    udp::test::append_datagrams(batch, datagrams);
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
  if (report.heard > group_->last_ordinal) return fail("a report of what was never sent");
  group_->membership.reported(now_);
}

udp::ResendWindow::Kept World::keep(const udp::JobHandle& job, bool elsewhere) {
  const udp::ResendWindow::Kept kept = window_->keep(job, job->first, elsewhere);
  const std::uint64_t end = window_->parting().end;
  for (std::uint64_t i = 0; i < job->samples(); ++i)
    sequences_.emplace(end - job->samples() + i, job->sequence + i);
  const std::uint64_t oldest = end - window_->kept();
  for (std::uint64_t i = oldest_kept_; i < oldest; ++i) not_kept_.insert(sequences_.at(i));
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
  if (reader.served_at != Time::max()) return;
  reader.accepted.push_back(from_to(random_, 0, 2));
  reader.served_at = now_ + std::chrono::microseconds(log_uniform(random_, 50'000));
}

void World::learn_of_masks() {
  for (Reader& reader : readers_) {
    if (reader.served_at > now_) continue;
    reader.served = reader.accepted.back();
    reader.served_at = Time::max();
  }
}

void World::send_some() {
  send_at_ = Time::max();
  send_some(Size::small);
  send_some(Size::large);
  send_heartbeat();
}

void World::send_some(Size size) {
  std::optional<Sending>& sending = sending_[static_cast<std::size_t>(size)];
  for (std::size_t i = 0; i < datagrams_at_once; ++i) {
    if (!sending) {
      std::optional<udp::ResendWindow::Piece> piece = window_->next(size, now_);
      if (!piece) return;
      const udp::Fragmenter fragments(piece->body(), scenario_.datagram_bytes, piece->range);
      sending.emplace(Sending{std::move(*piece), fragments});
    }
    if (!may_send(size)) return;
    udp::Batch batch;
    std::vector<Bytes> datagrams;
    sending->fragments.next(batch, udp::batch_bytes_max, 1);
    udp::test::append_datagrams(batch, datagrams);
    network_.send(Network::Side::reader, std::move(datagrams.front()), now_);
    flow_->sent(batch.bytes(), 1, now_);
    send_mark();
    if (!sending->fragments.done()) continue;
    happens(random_, 0.02) ? window_->put_back(sending->piece) : window_->finished(sending->piece, now_);
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
    return static_cast<void>(reassembly_->accept_offer(bytes, {}));
  shares_->count({});
  if (udp::kind_of(bytes) == udp::DatagramKind::heartbeat) {
    reassembly_->accept_heartbeat(bytes, {}, now);
  } else {
    const udp::Reassembly::Arrival arrival = reassembly_->accept(bytes, now);
    if (arrival.sample) take_at_once(*arrival.sample);
    for (const core::SampleHandle& sample : arrival.packed) take_at_once(*sample);
  }
  hand_over();
  answer();
}

void World::report(const Bytes& bytes) {
  const auto mark = udp::parse_mark(bytes);
  if (!mark) return fail("a mark is malformed");
  Bytes report(udp::report_bytes);
  udp::encode(shares_->answer(*mark, {}, now_), report.data());
  network_.send(Network::Side::writer, std::move(report), now_);
}

/// As a best-effort reader does.
void World::take_at_once(const core::SampleBuffer& sample) {
  if (!came_at_once_.emplace(sample.sequence, sample.mask.hash()).second)
    fail("sample " + std::to_string(sample.sequence) + " comes twice");
}

void World::answer() {
  reassembly_->answer(now_, [&](const udp::SocketAddress& to, const udp::Ack& ack) {
    if (to.port != writer_port) fail("an ack goes elsewhere");
    Bytes bytes(ack.bytes());
    udp::encode(ack, bytes.data());
    network_.send(Network::Side::writer, std::move(bytes), now_);
  });
  reassembly_->report([&](const udp::SocketAddress&, const udp::GroupReport& report) {
    Bytes bytes(udp::group_report_bytes);
    udp::encode(report, bytes.data());
    network_.send(Network::Side::writer, std::move(bytes), now_);
  });
  reassembly_->expire(now_);
}

void World::hand_over() {
  udp::ArrivalWindow& arrivals = *reassembly_->window(0);
  for (Reader& reader : readers_) {
    const auto accepts = [&](const core::SampleBuffer& sample) { return reader.accepts(sample); };
    while (const core::SampleHandle sample = arrivals.next(reader.id, accepts)) get(reader, *sample);
  }
  arrivals.release();
}

void World::get(Reader& reader, const core::SampleBuffer& sample) {
  const std::string which =
      "sample " + std::to_string(sample.sequence) + " of reader " + std::to_string(reader.id);
  if (sample.writer != writer_id) return fail(which + " names another writer");
  const auto image = images_.find(sample.sequence);
  if (image == images_.end()) return fail(which + " was never published");
  const std::span<const std::byte> body(sample.data + sample.header().body_offset,
                                        sample.header().body_bytes);
  if (!std::ranges::equal(body, udp::test::encoded_body(image->second, sample.mask)))
    return fail(which + " has other bytes, or those of another mask");
  if (!std::binary_search(reader.to_get.begin(), reader.to_get.end(), sample.sequence)) return;
  // While its mask changes, a sample can come under both, for it and for another.
  if (sample.sequence == reader.last && reader.accepted.size() > 1) return;
  if (sample.sequence <= reader.last) return fail(which + " comes after " + std::to_string(reader.last));
  reader.last = sample.sequence;
  reader.got.insert(sample.sequence);
}

Time World::next_event() const {
  Time next =
      std::min({network_.next(), publish_at_, crash_at_, back_at_, send_at_, window_->next_look(now_)});
  if (!leaving_.empty()) next = std::min(next, leaving_.front().at);
  for (const Reader& reader : readers_) next = std::min(next, reader.served_at);
  if (reassembly_ == nullptr) return next;
  return std::min({next, reassembly_->next_answer(), reassembly_->next_expiry().value_or(Time::max())});
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
  if (reassembly_ != nullptr) answer();
  check_limits();
  return failure_.empty();
}

void World::check_limits() {
  if (window_->kept() > scenario_.resend.samples) fail("the writer keeps too many samples");
  if (window_->kept_bytes() > scenario_.resend.bytes && window_->kept() > 1)
    fail("the writer keeps too much");
  if (reassembly_ == nullptr) return;
  const udp::ArrivalWindow& arrivals = *reassembly_->window(0);
  if (arrivals.size() > scenario_.reassembly.channel.samples) fail("the reader keeps too many places");
  if (arrivals.held_bytes() > scenario_.reassembly.channel.held_bytes + scenario_.sample_bytes_max)
    fail("the reader holds back too much");
}

/// Nothing is under way any more.
void World::check_end() {
  if (!window_->settled() && !readers_.empty()) fail("the writer waits for an ack that does not come");
  for (const Reader& reader : readers_) {
    for (const std::uint64_t sequence : reader.to_get) {
      if (reader.got.contains(sequence) || not_kept_.contains(sequence) || scenario_.tight_reader) continue;
      fail("reader " + std::to_string(reader.id) + " did not get sample " + std::to_string(sequence));
    }
  }
}

std::string World::run() {
  for (std::size_t steps = 0; step(); ++steps) {
    if (steps == steps_max) fail("it does not come to rest");
  }
  if (failure_.empty()) check_end();
  return failure_;
}

void World::fail(const std::string& what) {
  if (failure_.empty())
    failure_ = what + ", after " + std::to_string((now_ - Time(std::chrono::hours(1))) / 1us) + " us";
}

}  // namespace sft::simulation
