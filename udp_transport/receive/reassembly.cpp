#include "udp_transport/receive/reassembly.h"

#include <algorithm>
#include <utility>

#include "udp_transport/io/answer_address.h"

namespace sft::udp {

namespace {
constexpr std::size_t departed_max = 256;
}

Reassembly::Reassembly(const ReassemblyLimits& limits, std::shared_ptr<core::BufferPool> pool)
    : shared_(limits, std::move(pool)) {}

void Reassembly::set_streams(std::span<const Stream> streams) {
  auto before = std::exchange(writers_, {});
  by_stream_.clear();
  by_short_id_.clear();
  last_ = nullptr;
  windows_ = 0;
  for (const Stream& stream : streams) {
    std::unique_ptr<Known>& known = writers_[stream.writer];
    if (const auto found = before.find(stream.writer); found != before.end()) {
      known = std::move(found->second);
      before.erase(found);
    } else {
      known = std::make_unique<Known>(shared_);
    }
    known->writer.follow(stream, by_stream_.size());
    set_window(known->writer, stream);
    by_stream_.push_back(&known->writer);
  }
  note_short_ids(streams);
  for (auto& [id, known] : before) close_window(known->writer);
}

/// Makes the lists of writers with the same short id. Living writers come first in each list.
void Reassembly::note_short_ids(std::span<const Stream> streams) {
  for (const bool alive : {true, false}) {
    for (const Stream& stream : streams) {
      if (stream.alive != alive) continue;
      Known** last = &by_short_id_[static_cast<std::uint32_t>(stream.writer)];
      while (*last != nullptr) last = &(*last)->twin;
      *last = writers_.at(stream.writer).get();
      (*last)->twin = nullptr;
    }
  }
}

void Reassembly::set_window(IncomingWriter& writer, const Stream& stream) {
  if (!stream.reliable) return close_window(writer);
  ++windows_;
  if (writer.window() == nullptr) {
    const auto is_it = [&](const auto& item) { return item.first == writer.facts().id; };
    const auto departed = std::ranges::find_if(departed_, is_it);
    const bool is_known = departed != departed_.end();
    writer.open_window(is_known ? std::optional(departed->second) : std::nullopt);
    if (is_known) departed_.erase(departed);
  }
  writer.window()->set_awaited(stream.waits);
}

void Reassembly::close_window(IncomingWriter& writer) {
  const auto mark = writer.close_window();
  if (!mark) return;
  if (departed_.size() == departed_max) departed_.erase(departed_.begin());
  departed_.emplace_back(writer.facts().id, *mark);
}

/// Returns the writer of a datagram; null if no reader here reads a writer with that short id. An attacker
/// may announce writers with the short ids and the addresses of other writers. Among writers with the same
/// short id, the result is a writer whose node announced the address `from` and for which `fits(writer)` is
/// true. If there is none, it is a writer whose node announced that address, or else the first writer.
template <class Fits>
IncomingWriter* Reassembly::find(std::uint32_t short_id, const core::IpAddress& from, const Fits& fits) {
  if (is_of_last(short_id)) return last_;
  const auto found = by_short_id_.find(short_id);
  if (found == by_short_id_.end()) return nullptr;
  Known* const first = found->second;
  if (first->twin == nullptr) return last_ = &first->writer;
  IncomingWriter* from_there = nullptr;
  for (Known* one = first; one != nullptr; one = one->twin) {
    if (!is_announced(one->writer.facts().node, from)) continue;
    if (fits(one->writer)) return &one->writer;
    if (from_there == nullptr) from_there = &one->writer;
  }
  return from_there == nullptr ? &first->writer : from_there;
}

IncomingWriter* Reassembly::writer_of(const Datagram& d, const core::IpAddress& from) {
  return find(d.label().writer, from, [&](IncomingWriter& one) { return one.fits(d); });
}

IncomingWriter* Reassembly::writer_of(const Following& d, const core::IpAddress& from) {
  return find(d.label.writer, from, [&](IncomingWriter& one) { return one.fits(d); });
}

void Reassembly::refuse(const Malformed& d) {
  if (!d.kind || is_of_sample(*d.kind)) begin_datagram();
  ++shared_.counters.malformed;
}

Arrival Reassembly::accept(const Heartbeat& heartbeat, const Envelope& envelope) {
  const core::IpAddress& from = envelope.from.ip;
  IncomingWriter* const writer =
      find(heartbeat.writer, from, [&](IncomingWriter& one) { return one.follows(heartbeat.channel); });
  const auto answers_to = writer == nullptr || writer->window() == nullptr
                              ? std::nullopt
                              : answer_address(writer->facts().node, from, heartbeat.port);
  if (answers_to) return writer->accept(heartbeat, *answers_to, envelope);
  ++shared_.counters.unknown;
  return {};
}

std::optional<Reassembly::Joining> Reassembly::accept(const GroupOffer& offer, const Envelope& envelope) {
  const core::IpAddress& from = envelope.from.ip;
  IncomingWriter* const writer = find(offer.writer, from, [](IncomingWriter&) { return true; });
  const auto reports_to =
      writer == nullptr ? std::nullopt : answer_address(writer->facts().node, from, offer.port);
  if (!reports_to) {
    ++shared_.counters.unknown;
    return {};
  }
  const bool anew = writer->groups().hear(offer, *reports_to, envelope.now.steady);
  shared_.group_reports_due = shared_.group_reports_due || writer->groups().due();
  return Joining{offer.address, anew};
}

void Reassembly::accept(const GroupProbe& probe, const Envelope& envelope) {
  IncomingWriter* const writer = find(probe.writer, envelope.from.ip,
                                      [&](IncomingWriter& one) { return one.groups().knows(probe.group); });
  if (writer == nullptr) {
    ++shared_.counters.unknown;
    return;
  }
  writer->groups().hear(probe, envelope.now.steady);
  shared_.group_reports_due = shared_.group_reports_due || writer->groups().due();
}

std::vector<std::uint32_t> Reassembly::groups() const {
  std::vector<std::uint32_t> groups;
  for (IncomingWriter* writer : by_stream_) writer->groups().addresses(groups);
  return groups;
}

void Reassembly::report_groups(const SendGroupReport& send) {
  if (!std::exchange(shared_.group_reports_due, false)) return;
  for (IncomingWriter* writer : by_stream_) writer->groups().report(send);
}

void Reassembly::expire(Time now) {
  const std::optional<Time>& due = shared_.next_expiry();
  if (!due || now < *due) return;
  std::optional<Time> next;
  for (IncomingWriter* writer : by_stream_) writer->expire(now, next);
  shared_.set_next_expiry(next);
}

std::optional<SocketAddress> Reassembly::report_address(const core::IpAddress& from,
                                                        std::uint16_t port) const {
  const IncomingWriter* sender = nullptr;
  for (const IncomingWriter* writer : by_stream_) {
    const IncomingWriter::Facts& facts = writer->facts();
    if (is_announced(facts.node, from)) return answer_address(facts.node, from, port);
    if (facts.came_from == from) sender = writer;
  }
  return sender == nullptr ? std::nullopt : answer_address(sender->facts().node, from, port);
}

void Reassembly::came_from(std::size_t stream_index, const core::IpAddress& ip) {
  if (stream_index < by_stream_.size()) by_stream_[stream_index]->set_came_from(ip);
}

ArrivalWindow* Reassembly::window(std::size_t stream_index) {
  return stream_index < by_stream_.size() ? by_stream_[stream_index]->window() : nullptr;
}

void Reassembly::answer(Time now, const SendAck& send) {
  if (windows_ == 0) return;
  for (IncomingWriter* writer : by_stream_) writer->answer(now, send);
}

Reassembly::Time Reassembly::next_answer() const {
  Time next = Time::max();
  if (windows_ == 0) return next;
  for (const IncomingWriter* writer : by_stream_) next = std::min(next, writer->next_answer());
  return next;
}

}  // namespace sft::udp
