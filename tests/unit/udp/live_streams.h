// Streams of every kind between honest writers and one process that reads them, in simulated time. Both ends
// run the real protocol code. A test can insert additional datagrams.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/subscribe/sequence_account.h"
#include "tests/support/parse_datagram.h"
#include "tests/unit/udp/arrivals.h"
#include "tests/unit/udp/datagrams.h"
#include "udp_transport/flow/flow_window.h"
#include "udp_transport/flow/receive_shares.h"
#include "udp_transport/multicast/group_membership.h"
#include "udp_transport/outgoing/job.h"
#include "udp_transport/receive/inbox.h"
#include "udp_transport/receive/reassembly.h"
#include "udp_transport/reliable/resend_window.h"

namespace sft::udp::test {

enum class StreamKind : std::uint8_t { best_effort, best_effort_large, reliable, large, packed, group };
inline constexpr StreamKind all_stream_kinds[] = {StreamKind::best_effort, StreamKind::best_effort_large,
                                                  StreamKind::reliable,    StreamKind::large,
                                                  StreamKind::packed,      StreamKind::group};
inline const char* name_of(StreamKind kind) {
  constexpr const char* names[] = {"best effort", "best effort, large", "reliable", "large", "packed",
                                   "group"};
  return names[static_cast<std::size_t>(kind)];
}

class LiveStreams {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::milliseconds period{10};  ///< the time between two samples of a stream

  LiveStreams() {
    std::vector<Stream> wanted;
    for (const StreamKind kind : all_stream_kinds) {
      streams_.push_back(std::make_unique<One>(kind, 1 + streams_.size()));
      wanted.push_back({streams_.back()->writer, &type_support<Image>(), 0, {all()}, is_reliable(kind)});
    }
    reassembly_.set_streams(wanted);
    for (std::size_t i = 0; i < streams_.size(); ++i) {
      streams_[i]->inbox.connect({.writer = streams_[i]->writer});
      if (ArrivalWindow* window = reassembly_.window(i)) window->set_readers({1});
    }
  }

  Time now() const { return now_; }

  /// Simulates one millisecond: writers publish and send, and readers take the samples that arrived. Calls
  /// `between` before each honest datagram.
  template <class Between>
  void pass_a_millisecond(const Between& between) {
    now_ += std::chrono::milliseconds(1);
    for (const std::unique_ptr<One>& one : streams_) {
      if (now_ >= one->publish_at) publish(*one);
      for (const Bytes& datagram : datagrams_of(*one)) {
        between();
        captured_.push_back(datagram);
        receive(datagram);
      }
    }
    look_after();
    if (captured_.size() > 4000) captured_.erase(captured_.begin(), captured_.begin() + 2000);
  }

  /// Delivers the datagram, which may be forged, to the process.
  void receive(std::span<const std::byte> datagram) {
    if (const auto mark = parse_as<FlowMark>(datagram)) {
      shares_.answer(*mark, {}, now_);
    } else {
      shares_.count({});
      deliver(accept(reassembly_, datagram, {now_, 1}));
    }
    answer();
  }

  /// Returns the latest honest datagrams, of all kinds.
  const std::vector<Bytes>& captured() const { return captured_; }

  /// Returns the number of samples of the stream that were published at `time` or later and arrived
  /// unchanged.
  std::size_t came_since(StreamKind kind, Time time) const {
    const One& one = *streams_[static_cast<std::size_t>(kind)];
    std::size_t came = 0;
    for (const auto& [sequence, published] : one.published)
      came += published.came && published.at >= time ? 1 : 0;
    return came;
  }
  /// Returns the number of samples of the stream that arrived with different bytes than were published.
  std::size_t harmed(StreamKind kind) const { return streams_[static_cast<std::size_t>(kind)]->harmed; }
  /// Describes the state of both ends of the stream, for the message of a failure.
  std::string describe(StreamKind kind) {
    const auto i = static_cast<std::size_t>(kind);
    const One& one = *streams_[i];
    std::string text = name_of(kind) + std::string(": published up to ") + std::to_string(one.sequence) +
                       ", the subscriber got " + std::to_string(one.last) + " last, " +
                       std::to_string(one.harmed) + " were not what was published";
    ArrivalWindow* const window = reassembly_.window(i);
    if (window == nullptr) return text;
    const Ack ack = window->ack(0);
    return text + ", the writer keeps ordinals from " + std::to_string(one.window.begin()) + " to " +
           std::to_string(one.window.end()) + ", the reader awaits " + std::to_string(ack.next) +
           " of channel " + std::to_string(ack.channel) + " and has " +
           std::to_string(window->samples().slots().size()) + " places";
  }
  /// Returns the number of samples that the reader of the stream counts as lost.
  std::uint64_t lost(StreamKind kind) const { return streams_[static_cast<std::size_t>(kind)]->lost; }

 private:
  struct Published {
    Time at;
    Bytes body;
    bool came = false;
  };
  struct One {
    One(StreamKind of_kind, std::size_t number) : kind(of_kind), writer(0x7'0000'0000 + number) {}
    StreamKind kind;
    core::EndpointId writer;
    std::uint64_t sequence = 0;
    Time publish_at{};
    std::map<std::uint64_t, Published> published{};
    /// Jobs of best-effort streams and of the multicast group that are not sent yet.
    std::vector<JobHandle> unsent{};
    ResendWindow window{static_cast<std::uint32_t>(writer), 1, ResendLimits{}};
    GroupMembership membership{};
    std::uint64_t group_ordinal = 0;
    FlowWindow flow{static_cast<std::uint32_t>(writer), FlowLimits{}};
    Inbox inbox{8, nullptr};
    core::SequenceAccount account{};
    std::uint64_t lost = 0;
    std::uint64_t last = 0;  ///< the sequence of the sample that the reader took last
    std::size_t harmed = 0;
  };

  static const FieldMask& all() {
    static const FieldMask mask = fields<Image>("*");
    return mask;
  }
  static bool is_reliable(StreamKind kind) {
    return kind != StreamKind::best_effort && kind != StreamKind::best_effort_large;
  }

  void publish(One& one) {
    one.publish_at = now_ + period;
    const bool large = one.kind == StreamKind::large || one.kind == StreamKind::best_effort_large;
    JobHandle job = jobs_->take();
    job->mask = std::make_shared<WireMask>(WireMask{1, all().hash(), {}});
    job->sequence = one.sequence + 1;
    job->first = {
        .label = {static_cast<std::uint32_t>(one.writer), static_cast<std::uint32_t>(one.sequence + 1), 1},
        .mask = all().hash(),
        .stamp_ns = std::chrono::nanoseconds(now_.time_since_epoch()).count()};
    for (std::size_t left = one.kind == StreamKind::packed ? 5 : 1; left > 0; --left) {
      append(*job, one, make_image(large ? 20'000 : 50, static_cast<std::uint32_t>(++one.sequence)));
    }
    if (one.kind == StreamKind::packed) job->seal();
    if (!is_reliable(one.kind)) return one.unsent.push_back(job);
    const bool elsewhere = one.kind == StreamKind::group;
    const ResendWindow::Kept kept = one.window.keep(job, job->first, elsewhere && one.membership.hears());
    if (!elsewhere) return;
    one.membership.sent(now_);
    job->first.flags |= group_follows;
    job->first.group = {1, 0, ++one.group_ordinal};
    one.unsent.push_back(job);
    if (kept.elsewhere) one.window.departed(kept.ordinal, now_);
  }

  void append(Job& job, One& one, const Image& image) {
    core::SampleHandle sample = memory_->take(sample_bytes(image, all()));
    fill(*sample, image, all(), one.writer, one.sequence);
    one.published[one.sequence] = {now_, body_of(*sample)};
    if (one.published.size() > 2000) one.published.erase(one.published.begin());
    const TypeSupport& type = type_support<Image>();
    job.projection.project(core::state_of(*sample, type.index_slots()), type.type(), all());
    if (one.kind == StreamKind::packed) return job.pack(job.projection.segments());
    job.first.total = static_cast<std::uint32_t>(job.projection.bytes());
    job.copy_body();
  }

  std::vector<Bytes> datagrams_of(One& one) {
    std::vector<Bytes> datagrams;
    for (const JobHandle& job : std::exchange(one.unsent, {})) cut(job->body(), {}, datagrams);
    for (const auto size : {ResendWindow::Size::small, ResendWindow::Size::large}) {
      while (const std::optional<ResendWindow::Piece> piece = one.window.next(size, now_)) {
        cut(piece->body(), piece->range, datagrams);
        one.window.finished(*piece, now_);
      }
    }
    if (std::optional<Heartbeat> heartbeat = one.window.heartbeat(now_)) {
      heartbeat->port = 7;
      encode(*heartbeat, datagrams.emplace_back(heartbeat_bytes).data());
    }
    if (one.flow.room(FlowWindow::Size::small, now_) > 0 && !datagrams.empty()) {
      for (const Bytes& datagram : datagrams) one.flow.sent(datagram.size(), 1, now_);
    }
    if (std::optional<FlowMark> mark = one.flow.mark(now_)) {
      mark->port = 7;
      encode(*mark, datagrams.emplace_back(mark_bytes).data());
    }
    offer_group(one, datagrams);
    return datagrams;
  }

  static void cut(const EncodedBody& body, BodyRange range, std::vector<Bytes>& out) {
    Fragmenter fragments(body, 1472, range);
    while (!fragments.done()) {
      Batch batch;
      fragments.next(batch, batch_bytes_max, 1);
      append_datagrams(batch.parts(), batch.segment_bytes(), out);
    }
  }

  void offer_group(One& one, std::vector<Bytes>& datagrams) {
    if (one.kind != StreamKind::group || one.group_ordinal == 0) return;
    one.membership.look(now_);
    if (!one.membership.offer_due(now_)) return;
    encode(GroupOffer{.writer = static_cast<std::uint32_t>(one.writer),
                      .group = 1,
                      .member = 1,
                      .port = 7,
                      .address = private_groups + 1,
                      .channel = 1,
                      .ahead = 0},
           datagrams.emplace_back(group_offer_bytes).data());
  }

  /// Delivers samples to best-effort readers at once, and to reliable readers in order.
  void deliver(const Arrival& arrival) {
    One& one = *streams_[arrival.stream];
    const bool at_once = !is_reliable(one.kind);
    if (at_once && arrival.sample) one.inbox.deliver(arrival.sample);
    for (const core::SampleHandle& sample : arrival.packed) {
      if (at_once) one.inbox.deliver(sample);
    }
    if (arrival.in_channel) deliver_in_order(arrival.stream);
    take(one);
  }

  void deliver_in_order(std::size_t stream) {
    ArrivalWindow& window = *reassembly_.window(stream);
    const auto accepts = [](const core::SampleBuffer& s, std::uint64_t) { return s.mask == all(); };
    while (const core::SampleHandle sample = window.next(1, accepts)) {
      streams_[stream]->inbox.deliver(sample);
      take(*streams_[stream]);
    }
    window.release();
  }

  /// Takes the available samples like a subscriber, and compares them with the published ones.
  void take(One& one) {
    while (const core::SampleHandle sample = one.inbox.take()) {
      const core::SampleOrigin origin{.sequence = sample->sequence, .numbering = sample->numbering};
      if (!one.account.is_new(origin)) {
        one.account.refuse(origin);
        continue;
      }
      one.lost += one.account.enter(origin, core::RateKeeper::writer, {}).lost;
      one.last = sample->sequence;
      // A sample without a channel carries only the low half of its sequence number.
      const std::uint64_t said =
          is_reliable(one.kind) ? sample->sequence : static_cast<std::uint32_t>(sample->sequence);
      const auto published = one.published.find(said);
      const bool sound =
          published != one.published.end() && same_bytes(published->second.body, body_of(*sample));
      if (sound) published->second.came = true;
      one.harmed += sound ? 0 : 1;
    }
  }

  void look_after() {
    reassembly_.expire(now_);
    for (std::size_t i = 0; i < streams_.size(); ++i) {
      if (is_reliable(streams_[i]->kind)) deliver_in_order(i);
    }
    answer();
  }

  void answer() {
    reassembly_.answer(now_, [&](const SocketAddress&, const Ack& ack) {
      for (const std::unique_ptr<One>& one : streams_) one->window.hear(ack, now_);
    });
    reassembly_.report_groups([&](const SocketAddress&, const GroupReport& report) {
      for (const std::unique_ptr<One>& one : streams_) {
        const bool is_ours = static_cast<std::uint32_t>(one->writer) == report.writer && report.group == 1;
        if (!is_ours || report.heard > one->group_ordinal) continue;
        if (report.heard == 0) {
          one->membership.refused(one->group_ordinal, now_);
        } else {
          one->membership.reported(report.heard, now_);
        }
      }
    });
  }

  Time now_{std::chrono::hours(1)};
  std::shared_ptr<JobPool> jobs_ = JobPool::make();
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(std::size_t{64} << 20);
  Reassembly reassembly_{{}, memory_};
  ReceiveShares shares_{212'992};
  std::vector<std::unique_ptr<One>> streams_;
  std::vector<Bytes> captured_;
};

}  // namespace sft::udp::test
