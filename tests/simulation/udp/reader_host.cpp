#include "tests/simulation/udp/reader_host.h"

#include <algorithm>
#include <chrono>
#include <optional>

#include "tests/support/parse_datagram.h"
#include "tests/unit/udp/arrivals.h"

namespace sft::simulation {

void ReaderHost::start() {
  reassembly_ = std::make_unique<udp::Reassembly>(scenario_.reassembly, memory_);
  directory_ = std::make_unique<udp::SubscriptionDirectory>();
  shares_ = std::make_unique<udp::ReceiveShares>(scenario_.receive_buffer_bytes);
  readers_.clear();
  laws_.process_started();
  for (std::size_t i = 0; i < from_to(random_, 1, 3); ++i) {
    Reader& reader = add_reader(from_to(random_, 0, scenario_.asking.wishes - 1));
    reader.known = reader.asked;
  }
  follow();
}

ReaderHost::Reader& ReaderHost::add_reader(Wish wish) {
  readers_.push_back({.id = ++last_id_,
                      .inbox = std::make_shared<udp::Inbox>(1, nullptr),
                      .requests = core::AcceptedRequests({wishes()[wish]}, true),
                      .asked = wish});
  Reader& reader = readers_.back();
  laws_.reader_joined(reader.id);
  laws_.asks(reader.id, wishes()[wish]);
  directory_->add(reader.id, reader.inbox, cloud_type());
  directory_->accept(*reader.inbox, reader.requests.all());
  const core::Source source{.writer = writer_id, .reliable = true, .waits = scenario_.readers_lag};
  if (!directory_->connect(*reader.inbox, source)) laws_.fail("a reader is not connected");
  return reader;
}

/// Gives the present wishes of the readers to the reassembly.
void ReaderHost::follow() {
  subscriptions_ = directory_->enter();
  reassembly_->set_streams(subscriptions_->streams);
  std::vector<core::EndpointId> ids;
  for (const Reader& reader : readers_) ids.push_back(reader.id);
  reassembly_->window(0)->set_readers(ids);
  for (const udp::Subscriber& subscriber : subscriptions_->subscribers[0])
    reassembly_->window(0)->heard(subscriber.reader, subscriber.heard_request());
}

void ReaderHost::crash() {
  reassembly_.reset();
  readers_.clear();
  departed_.clear();
  laws_.process_crashed();
  look_again_at_ = Time::max();
}

std::map<core::EndpointId, Wish> ReaderHost::wishes_known() const {
  std::map<core::EndpointId, Wish> known;
  for (const Reader& reader : readers_)
    if (reader.known) known.emplace(reader.id, *reader.known);
  for (const Departed& reader : departed_) known.emplace(reader.id, reader.known);
  return known;
}

/// Returns a random wish. If readers join and leave in this run, the result often is the wish of another
/// reader, so that a group may serve both readers.
Wish ReaderHost::any_wish() {
  const bool as_another = scenario_.asking.churn != 0 && happens(random_, 0.5);
  if (as_another) return readers_[from_to(random_, 0, readers_.size() - 1)].asked;
  return from_to(random_, 0, scenario_.asking.wishes - 1);
}

void ReaderHost::change_a_wish(Time now) {
  if (readers_.empty()) return;
  Reader& reader = readers_[from_to(random_, 0, readers_.size() - 1)];
  const Wish wish = any_wish();
  if (reader.requests.latest().selection == wishes()[wish]) return;
  ++changes_;
  reader.asked = wish;
  reader.requests.asks_for({wishes()[wish]}, now);
  laws_.asks(reader.id, wishes()[wish]);
  directory_->accept(*reader.inbox, reader.requests.all());
  follow();
  announce(reader, now);
}

/// Sends the reader's request to the writer.
void ReaderHost::announce(Reader& reader, Time now) {
  const Time after = reader.under_way.empty() ? now : reader.under_way.back().first;
  const auto delay = std::chrono::microseconds(log_uniform(random_, 50'000));
  reader.under_way.emplace_back(std::max(after, now + delay), reader.asked);
}

void ReaderHost::come_or_go(Time now) {
  constexpr std::size_t readers_max = 4;
  if (readers_.empty()) return;
  ++changes_;
  const bool joins = readers_.size() == 1 || (readers_.size() < readers_max && happens(random_, 0.4));
  joins ? join(now) : leave(now);
}

void ReaderHost::join(Time now) {
  Reader& reader = add_reader(any_wish());
  follow();
  announce(reader, now);
}

void ReaderHost::leave(Time now) {
  const std::size_t place = from_to(random_, 1, readers_.size() - 1);
  const Reader reader = std::move(readers_[place]);
  readers_.erase(readers_.begin() + static_cast<std::ptrdiff_t>(place));
  laws_.reader_left(reader.id);
  directory_->leave();
  directory_->remove(*reader.inbox);
  follow();
  const auto delay = std::chrono::microseconds(log_uniform(random_, 50'000));
  if (reader.known) departed_.push_back({reader.id, *reader.known, now + delay});
}

void ReaderHost::check_kept() {
  if (subscriptions_->streams.size() != 1) return laws_.fail("there is more than one stream");
  if (subscriptions_->subscribers[0].size() != readers_.size())
    return laws_.fail("readers that have left are still known");
  constexpr std::size_t groups_max = 4;
  if (reassembly_->groups().size() > groups_max) return laws_.fail("former groups are kept");
  for (const Reader& reader : readers_)
    if (reader.requests.all().size() > core::AcceptedRequests::reliable_max)
      return laws_.fail("former requests are kept");
}

void ReaderHost::notify_writer_of_wishes(Time now) {
  std::erase_if(departed_, [now](const Departed& reader) { return reader.until <= now; });
  for (Reader& reader : readers_) {
    while (!reader.under_way.empty() && reader.under_way.front().first <= now) {
      reader.known = reader.under_way.front().second;
      reader.under_way.pop_front();
      if (reader.under_way.empty()) laws_.is_heard(reader.id);
    }
    if (!reader.requests.look(now)) continue;
    directory_->accept(*reader.inbox, reader.requests.all());
    follow();
  }
}

void ReaderHost::receive(const Bytes& bytes, Time now) {
  if (reassembly_ == nullptr) return;
  if (udp::kind_of(bytes) == udp::DatagramKind::mark) return report(bytes, now);
  if (udp::kind_of(bytes) == udp::DatagramKind::group_offer)
    return static_cast<void>(udp::test::accept(*reassembly_, bytes, {now, 1}));
  shares_->count({});
  accept(bytes, now);
  hand_over(now);
  answer(now);
}

void ReaderHost::accept(const Bytes& bytes, Time now) {
  const auto before = arrivals()->mark();
  const std::optional<udp::Datagram> samples = udp::parse(bytes);
  const std::set<std::uint64_t> awaited = awaited_of(samples);
  const std::uint64_t refused_before = reassembly_->counters().unknown;
  const udp::Arrival arrival = udp::test::accept(*reassembly_, bytes, {now, 1});
  const std::optional<udp::Heartbeat> heartbeat = udp::parse_as<udp::Heartbeat>(bytes);
  if (!heartbeat && reassembly_->counters().unknown > refused_before) refuse(samples, awaited);
  if (arrival.sample) laws_.came(*arrival.sample);
  for (const core::SampleHandle& sample : arrival.packed) laws_.came(*sample);
  laws_.loss_account().heard(before, arrivals()->mark(), heartbeat);
}

/// Returns the samples of the datagram that the window still awaits, as numbers of their places in the
/// datagram.
std::set<std::uint64_t> ReaderHost::awaited_of(const std::optional<udp::Datagram>& datagram) {
  std::set<std::uint64_t> awaited;
  const std::uint64_t samples = datagram ? std::max<std::uint64_t>(datagram->samples, 1) : 0;
  for (std::uint64_t i = 0; i < samples; ++i) {
    if (!has_decided(datagram->first.channel, i)) awaited.insert(i);
  }
  return awaited;
}

/// Records that no reader has requested the selection of the datagram. The window has passed over the samples
/// for which it had room. The other samples of the datagram will arrive again.
void ReaderHost::refuse(const std::optional<udp::Datagram>& datagram,
                        const std::set<std::uint64_t>& awaited) {
  if (!datagram) return laws_.fail_unless_forged("what makes no sense is taken for unwanted");
  const bool is_pack = datagram->samples > 1;
  for (const std::uint64_t i : awaited) {
    if (!is_pack || has_decided(datagram->first.channel, i)) laws_.refused(datagram->first, i);
  }
}

/// Returns true if the sample `behind` places after the mark has arrived, was passed over, or is lost.
bool ReaderHost::has_decided(const udp::ChannelMark& mark, std::uint64_t behind) {
  const auto known = arrivals()->mark();
  if (!known || known->channel != mark.channel) return false;
  const std::uint64_t place = mark.ordinal + behind - arrivals()->ordinal_of(0);
  const auto& slots = arrivals()->samples().slots();
  return place < slots.begin() || (slots.contains(place) && slots[place].settled());
}

void ReaderHost::report(const Bytes& bytes, Time now) {
  const auto mark = udp::parse_as<udp::FlowMark>(bytes);
  if (!mark) return laws_.fail_unless_forged("a mark is malformed");
  Bytes report(udp::report_bytes);
  udp::encode(shares_->answer(*mark, {}, now), report.data());
  network_.send(Network::Side::writer, std::move(report), now);
}

void ReaderHost::look(Time now) {
  if (reassembly_ == nullptr) return;
  if (look_again_at_ <= now) hand_over(now);
  answer(now);
}

void ReaderHost::hand_over(Time now) {
  for (std::size_t i = 0; i < readers_.size(); ++i) {
    const Reader& reader = readers_[i];
    const udp::Subscriber& subscriber = subscriptions_->subscribers[0][i];
    const auto accepts = [&](const core::SampleBuffer& sample, std::uint64_t request) {
      return subscriber.accepts(sample, request);
    };
    for (std::size_t room = room_now(); room > 0; --room) {
      const core::SampleHandle sample = arrivals()->next(reader.id, accepts);
      if (!sample) break;
      laws_.taken(reader.id, *sample, reader.requests.all().size() > 1);
    }
  }
  arrivals()->release();
  look_again_at_ =
      arrivals()->holds_back() ? now + std::chrono::microseconds(log_uniform(random_, 20'000)) : Time::max();
}

/// Returns the room in the queue of a reader, in samples. The queue is sometimes full.
std::size_t ReaderHost::room_now() {
  const bool lags = scenario_.readers_lag && !arrivals()->overtakes();
  return lags ? from_to(random_, 0, 2) : SIZE_MAX;
}

void ReaderHost::answer(Time now) {
  reassembly_->answer(now, [&](const udp::SocketAddress& to, const udp::Ack& ack) {
    if (to.port != writer_port) return laws_.fail_unless_forged("an ack goes elsewhere");
    Bytes bytes(ack.bytes());
    udp::encode(ack, bytes.data());
    network_.send(Network::Side::writer, std::move(bytes), now);
  });
  reassembly_->report_groups([&](const udp::SocketAddress&, const udp::GroupReport& report) {
    Bytes bytes(udp::group_report_bytes);
    udp::encode(report, bytes.data());
    network_.send(Network::Side::writer, std::move(bytes), now);
  });
  reassembly_->expire(now);
}

Time ReaderHost::next() const {
  if (reassembly_ == nullptr) return Time::max();
  Time next = std::min(
      {look_again_at_, reassembly_->next_answer(), reassembly_->next_expiry().value_or(Time::max())});
  for (const Reader& reader : readers_) {
    if (!reader.under_way.empty()) next = std::min(next, reader.under_way.front().first);
  }
  return next;
}

}  // namespace sft::simulation
