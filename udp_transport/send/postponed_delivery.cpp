#include "udp_transport/send/postponed_delivery.h"

#include <atomic>
#include <chrono>

namespace sft::udp {

namespace {
/// The number of bytes that are copied at a time. After each such copy, it is checked if the channel still
/// needs the rest.
constexpr std::size_t copied_at_a_time = 128 * 1024;
}  // namespace

bool PostponedDelivery::is_possible(const Audience& audience) {
  if (audience.multicast != nullptr || audience.late_reader != 0 || audience.lanes.size() != 1) return false;
  const Lane& lane = *audience.lanes.front();
  // An older large sample may wait in a lane of another mask. A channel keeps the order by itself.
  const bool may_overtake =
      audience.channels.front() == nullptr && lane.tally().busy_lanes.load(std::memory_order_acquire) != 0;
  return !lane.is_late() && lane.is_clear() && !may_overtake && lane.destination().bulk_in_use() != nullptr;
}

std::optional<std::size_t> PostponedDelivery::send(const Audience& audience,
                                                   const core::SampleHandle& sample) {
  located_.clear();
  sample->postponed->locate(unicast_.job().projection.segments(), located_);
  const std::shared_ptr<Lane>& lane = audience.lanes.front();
  const std::shared_ptr<Channel>& channel = audience.channels.front();
  return channel == nullptr ? send_once(lane, sample) : send_reliably(*lane, channel, sample);
}

/// Sends by best effort. The sample is completed by copying only if the sending thread has to send the rest.
std::size_t PostponedDelivery::send_once(const std::shared_ptr<Lane>& lane,
                                         const core::SampleHandle& sample) {
  Job& job = unicast_.job();
  const std::uint32_t sent = send_located(job.first, lane->destination());
  lane->stay_behind(lane->destination().window().position());
  if (sent == job.first.total) return 0;
  job.sent_bytes = sent;
  sample->complete();
  unicast_.keep(sample);
  return unicast_.enqueue(lane);
}

/// Sends reliably. Then copies the parts that may have to be sent again. Copying stops when the sample is
/// acknowledged.
std::optional<std::size_t> PostponedDelivery::send_reliably(Lane& lane,
                                                            const std::shared_ptr<Channel>& channel,
                                                            const core::SampleHandle& sample) {
  unicast_.keep(sample);
  std::optional<Channel::Posted> posted =
      channel->post_ahead(unicast_.handle(), unicast_.job().first, unicast_.timeout());
  if (!posted) return {};
  Channel::Piece& piece = *posted->piece;
  piece.range.begin = send_located(piece.first, channel->destination());
  channel->stay_behind(channel->destination().window().position());
  while (!sample->postponed->empty() && channel->keeps(piece.ordinal))
    sample->postponed->make(copied_at_a_time);
  if (piece.range.begin == piece.first.total) {
    const Wake wake = channel->finished(piece, std::chrono::steady_clock::now());
    posted->wake = strongest(posted->wake, wake);
  } else {
    channel->put_back(piece);
    posted->wake = strongest(posted->wake, Wake::look);
  }
  return unicast_.settle(*posted, channel, lane, 1);
}

}  // namespace sft::udp
