#include "tests/simulation/udp/channel_sender.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "tests/simulation/udp/topic.h"
#include "tests/support/parse_datagram.h"
#include "tests/unit/udp/datagrams.h"

namespace sft::simulation {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t datagrams_at_once = 6;
constexpr auto send_pause = 60us;

}  // namespace

ChannelSender::ChannelSender(const Scenario& scenario, Random& random, Network& network,
                             LossAccount& loss_account)
    : scenario_(scenario), random_(random), network_(network), loss_account_(loss_account) {
  open();
}

void ChannelSender::open() {
  const std::uint64_t first = number_ == 0 ? scenario_.first_ordinal : 1;
  oldest_kept_ = first;
  window_ = std::make_unique<udp::ResendWindow>(writer_label, ++number_, scenario_.resend, first);
  flow_ = std::make_unique<udp::FlowWindow>(number_, udp::FlowLimits{});
  for (auto& sending : sending_) sending.reset();
}

udp::ResendWindow::Kept ChannelSender::keep(const udp::JobHandle& job, bool elsewhere) {
  const udp::ResendWindow::Kept kept = window_->keep(job, job->first, elsewhere);
  const std::uint64_t end = window_->parting().end;
  for (std::uint64_t i = 0; i < job->samples(); ++i)
    loss_account_.sent(number_, end - job->samples() + i, {job->sequence + i, job->first.mask});
  const std::uint64_t oldest = end - window_->kept();
  for (std::uint64_t i = oldest_kept_; i < oldest; ++i) loss_account_.dropped(number_, i);
  oldest_kept_ = oldest;
  return kept;
}

void ChannelSender::wake(Time now) { send_at_ = std::min(send_at_, now); }

void ChannelSender::send(Time now) {
  send_at_ = Time::max();
  if (now >= scenario_.stalled_from && now < scenario_.stalled_until) {
    send_at_ = scenario_.stalled_until;
  } else {
    send_some(Size::small, now);
    send_some(Size::large, now);
  }
  send_heartbeat(now);
}

void ChannelSender::send_some(Size size, Time now) {
  std::optional<Sending>& sending = sending_[static_cast<std::size_t>(size)];
  for (std::size_t i = 0; i < datagrams_at_once; ++i) {
    if (!sending && !begin_piece(sending, size, now)) return;
    if (!may_send(size, now)) return;
    send_datagram(*sending, now);
    send_mark(now);
    if (!sending->fragments.done()) continue;
    end_piece(*sending, now);
    sending.reset();
  }
  send_at_ = now + send_pause;
}

/// Begins to send the next piece of that size. Returns false if no piece is due now.
bool ChannelSender::begin_piece(std::optional<Sending>& sending, Size size, Time now) {
  std::optional<udp::ResendWindow::Piece> piece = window_->next(size, now);
  if (!piece) return false;
  const udp::Fragmenter fragments(piece->body(), network_.datagram_bytes(), piece->range);
  sending.emplace(Sending{std::move(*piece), fragments});
  return true;
}

bool ChannelSender::may_send(Size size, Time now) {
  using FlowSize = udp::FlowWindow::Size;
  if (flow_->room(size == Size::small ? FlowSize::small : FlowSize::large, now) > 0) return true;
  send_mark(now);
  send_at_ = std::min(send_at_, std::max(flow_->next_ready(now), now + 1us));
  return false;
}

void ChannelSender::send_datagram(Sending& sending, Time now) {
  udp::Batch batch;
  std::vector<Bytes> datagrams;
  sending.fragments.next(batch, udp::batch_bytes_max, 1);
  udp::test::append_datagrams(batch.parts(), batch.segment_bytes(), datagrams);
  network_.send(Network::Side::reader, std::move(datagrams.front()), now);
  flow_->sent(batch.bytes(), 1, now);
}

/// Finishes a piece after its last datagram. Sometimes puts the piece back instead, as if its rest had to be
/// sent later.
void ChannelSender::end_piece(Sending& sending, Time now) {
  if (!happens(random_, 0.02)) return window_->finished(sending.piece, now);
  if (sending.piece.job->samples() == 1) sending.piece.range.begin = random_() % sending.piece.first.total;
  window_->put_back(sending.piece);
}

void ChannelSender::send_mark(Time now) {
  std::optional<udp::FlowMark> mark = flow_->mark(now);
  if (!mark) return;
  mark->port = writer_port;
  Bytes bytes(udp::mark_bytes);
  udp::encode(*mark, bytes.data());
  network_.send(Network::Side::reader, std::move(bytes), now);
}

void ChannelSender::send_heartbeat(Time now) {
  std::optional<udp::Heartbeat> heartbeat = window_->heartbeat(now);
  if (!heartbeat) return;
  heartbeat->port = writer_port;
  Bytes bytes(udp::heartbeat_bytes);
  udp::encode(*heartbeat, bytes.data());
  network_.send(Network::Side::reader, std::move(bytes), now);
}

void ChannelSender::hear(const Bytes& bytes, Time now) {
  if (const auto ack = udp::parse_as<udp::Ack>(bytes)) {
    window_->hear(*ack, now);
    oldest_kept_ = window_->parting().first - window_->kept();
  } else if (const auto report = udp::parse_as<udp::FlowReport>(bytes)) {
    if (!flow_->hear(*report, now)) return;
  }
  wake(now);
}

Time ChannelSender::next(Time now) const { return std::min(send_at_, window_->next_look(now)); }

}  // namespace sft::simulation
