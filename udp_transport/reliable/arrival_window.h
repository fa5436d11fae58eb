// The reader's end of a channel (wire_format.md). It decides which datagrams and heartbeats of the writer
// are accepted, and gives each sample a place: its number over all channels of the writer. It hands samples
// to the readers of this process, and makes the acks and their requests for missing data. Uses no clock,
// thread or I/O: events and times are passed in, answers are returned.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/seam/transport.h"
#include "udp_transport/reliable/arrival_limits.h"
#include "udp_transport/reliable/arrived_samples.h"
#include "udp_transport/reliable/channel_monitor.h"
#include "udp_transport/reliable/channel_places.h"
#include "udp_transport/reliable/ordinal_monitor.h"
#include "udp_transport/reliable/pending_ack.h"
#include "udp_transport/reliable/reader_cursors.h"
#include "udp_transport/reliable/reported_end.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class ArrivalWindow {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Place = std::uint64_t;

  explicit ArrivalWindow(const ArrivalLimits& limits)
      : limits_(limits), samples_(limits), pending_ack_(limits.ack_bytes) {}

  /// The progress of a window at the time when the last reader of the writer left.
  struct Mark {
    std::uint32_t channel = 0;
    std::uint64_t end = 0;  ///< the ordinal after the last known sample
  };
  std::optional<Mark> mark() const;
  /// Continues for a writer that has readers again. If the channel is the same, the window begins with the
  /// next sample that comes, and skips the samples that were sent meanwhile.
  void join(const Mark& left);

  /// The decision about the first datagram of a sample.
  enum class Standing : std::uint8_t {
    wanted,
    known,  ///< the sample or its first datagram has come already, or the sample is no longer needed
    /// The sample belongs to an earlier channel, or is too far ahead for the window. The writer will send it
    /// again.
    beyond,
  };
  struct Met {
    Standing standing{};
    Place place = 0;
  };
  /// Decides about the first datagram of a sample by the channel mark in it. `same_datagram` is true if the
  /// previous channel mark was in the same datagram.
  Met meet(const ChannelMark& mark, Time now, bool same_datagram = false);

  // The next three functions, and those of the object that samples() returns, take a place that meet()
  // returned.

  void whole(Place place, core::SampleHandle sample);
  /// Notes that the sample at that place will not come, or is for no reader of this process.
  void pass(Place place);
  /// Notes that the sample is invalid although each of its datagrams is valid. The first time, the sample is
  /// requested again. The second time, it is skipped.
  void refuse_or_pass(Place place);
  ArrivedSamples& samples() { return samples_; }

  void hear(const Heartbeat& heartbeat, Time now);

  struct AnyRoom {
    bool operator()(const core::SampleBuffer&) const { return true; }
  };
  /// Returns the next sample for that reader, in order; empty if none has arrived yet, or if the reader has
  /// no room for it. `accepts(buffer, request)` returns true if the sample in `buffer`, of which at least a
  /// part has arrived, is for the reader. `request` is the reader's request in force. `has_room(buffer)`
  /// returns true if the reader can take the sample, which is whole.
  template <class Accepts, class HasRoom = AnyRoom>
  core::SampleHandle next(core::EndpointId reader, const Accepts& accepts, const HasRoom& has_room = {});
  /// Sets the readers of the writer. New readers begin with the first sample that has not arrived yet.
  void set_readers(const std::vector<core::EndpointId>& readers) { readers_.set(readers, samples_.next()); }
  /// Notes that the writer now serves that reader under `request` or a later request. Samples under earlier
  /// requests may still be under way. The writer's next heartbeat names the end of these samples.
  void heard(core::EndpointId reader, std::uint64_t request) { readers_.heard(reader, request); }
  /// Releases the samples that all readers have taken.
  void release();

  /// Sets whether the writer waits for its readers. If it does, a sample is not acknowledged until all
  /// readers have taken it.
  void set_awaited(bool awaited) { awaited_ = awaited; }
  /// Returns true if some reader has not taken an arrived sample. Must be called after release().
  bool holds_back() const { return samples_.slots().begin() < samples_.next(); }
  /// Returns true if the window does not wait for lagging readers, because too many bytes wait for them or
  /// the writer is too far ahead. Then samples are handed to readers even if their full queues drop older
  /// samples.
  bool overtakes() const { return overtakes_; }

  /// Returns the time at which samples().due_gaps() may return a gap; Time::max() if no gap is known.
  Time next_look() const { return samples_.schedule().next_look(); }
  /// Returns the ordinal of a place in the present channel.
  std::uint64_t ordinal_of(Place place) const { return places_.ordinal_of(place); }
  /// Returns true if an ack is due now.
  bool ack_due() const { return pending_ack_.due(); }
  /// Returns an ack that requests no missing parts yet. The ack counts as sent.
  Ack ack(std::uint32_t writer);

  const ChannelMonitor& channels() const { return channels_; }

 private:
  /// The maximum length of a heartbeat's range of ordinals. No writer keeps more samples, so a heartbeat
  /// with a longer range is ignored.
  static constexpr std::uint64_t kept_max = OrdinalMonitor::remembered;

  bool turn_to(const ChannelMonitor::Observed& observed, Time now);
  void begin_channel(std::uint64_t ordinal);
  void go_back_to(std::uint64_t ordinal);
  void begin_with(Place place);
  Met meet_passed_over(const ChannelMark& mark, Time now, bool same_datagram);
  bool follow(const Heartbeat& heartbeat, Time heard_before, Time now);
  bool contradicts(const Heartbeat& heartbeat, Time now);
  bool was_never_published(const Heartbeat& heartbeat, Time now);
  void ask_for_next(Time now);

  const ArrivalLimits limits_;
  ChannelMonitor channels_;
  ChannelPlaces places_;
  OrdinalMonitor ordinals_;
  ReportedEnd reported_end_;
  bool joining_ = false;  ///< true if no sample or heartbeat has come since join()
  bool fresh_ = true;     ///< true if no ordinal of the channel is known yet
  ArrivedSamples samples_;
  ReaderCursors readers_;
  PendingAck pending_ack_;
  bool awaited_ = false;
  bool overtakes_ = false;
};

template <class Accepts, class HasRoom>
core::SampleHandle ArrivalWindow::next(core::EndpointId reader, const Accepts& accepts,
                                       const HasRoom& has_room) {
  using State = ArrivedSamples::State;
  ReaderCursors::Cursor* const cursor = readers_.find(reader);
  if (cursor == nullptr) return {};
  const OrdinalRing<ArrivedSamples::Slot>& slots = samples_.slots();
  Place& place = cursor->place;
  place = std::max(place, slots.begin());
  while (slots.contains(place)) {
    const ArrivedSamples::Slot& slot = slots[place];
    if (slot.state == State::missing) return {};
    cursor->turn();
    const bool is_for_it = slot.sample && accepts(*slot.sample, cursor->request);
    if (is_for_it && (slot.state == State::begun || !has_room(*slot.sample))) return {};
    ++place;
    if (is_for_it) return slot.sample;
  }
  return {};
}

}  // namespace sft::udp
