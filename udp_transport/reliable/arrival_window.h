// The reader's end of a channel (wire_format.md): decides what datagrams and heartbeats of the writer count,
// and which place each sample has; hands samples over to the readers of this process; and tells what to
// acknowledge and what to ask for. Pure: calls and times in, answers out.
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

  /// The progress of a window when nobody heard the writer any more.
  struct Mark {
    std::uint32_t channel = 0;
    std::uint64_t end = 0;  ///< ordinal behind the last one that was known of
  };
  std::optional<Mark> mark() const;
  /// A new window, of a writer that is heard again. In the same channel it begins with the first sample that
  /// it hears of, not with those that were sent meanwhile.
  void join(const Mark& left);

  /// The treatment of a first datagram.
  enum class Standing : std::uint8_t {
    wanted,
    known,   ///< it, or its whole sample, has come already, or is not wanted any more
    beyond,  ///< it is of a channel of before, or there is no room for it; it will come again
  };
  struct Met {
    Standing standing{};
    Place place = 0;
  };
  /// `same_datagram`: the last one that was met came in the same datagram.
  Met meet(const ChannelMark& mark, Time now, bool same_datagram = false);

  // These three functions, and those of samples(), are about a place that was met.

  void whole(Place place, core::SampleHandle sample);
  /// Tells that its sample will not come, or is for nobody here.
  void pass(Place place);
  /// Tells that its sample makes no sense, although each datagram of it made sense. The sample is asked for
  /// again; after the second time it is passed over.
  void refuse_or_pass(Place place);
  ArrivedSamples& samples() { return samples_; }

  void hear(const Heartbeat& heartbeat, Time now);

  /// The next sample for that reader, in order; empty if there is none as yet. `accepts(buffer, request)`
  /// tells whether one is for it, once anything of it has come; those of its requests before `request` are
  /// over.
  template <class Accepts>
  core::SampleHandle next(core::EndpointId reader, const Accepts& accepts);
  /// Sets who reads from now on. New readers begin with the first sample that has not arrived yet.
  void set_readers(const std::vector<core::EndpointId>& readers) { readers_.set(readers, samples_.next()); }
  /// Tells that the writer's samples are by now for that reader under that request, or a later one. Samples
  /// that were published before may be under way for any time: up to the position that the next heartbeat
  /// gives for the writer.
  void heard(core::EndpointId reader, std::uint64_t request) { readers_.heard(reader, request); }
  /// Lets go of what all of them have.
  void release();

  /// The writer waits for readers: what they have not got is not acknowledged, though it has come.
  void set_awaited(bool awaited) { awaited_ = awaited; }
  /// Something is there that not all of them have, after release().
  bool holds_back() const { return samples_.slots().begin() < samples_.next(); }
  /// True if the window goes on without lagging readers, or holds too much for them: they have to be given
  /// some.
  bool overtakes() const { return overtakes_; }

  /// The time when samples().due_gaps() may find something; Time::max() if never.
  Time next_look() const { return samples_.schedule().next_look(); }
  /// The ordinal of a place in the present channel.
  std::uint64_t ordinal_of(Place place) const { return places_.ordinal_of(place); }
  /// True if something is to be acknowledged now.
  bool ack_due() const { return pending_ack_.due(); }
  /// Returns an ack without the missing samples; it counts as sent.
  Ack ack(std::uint32_t writer);

  const ChannelMonitor& channels() const { return channels_; }

 private:
  /// No writer keeps more samples than this, so no heartbeat spans more.
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
  bool joining_ = false;  ///< nothing was heard yet since join()
  bool fresh_ = true;     ///< no ordinal of the channel is known yet
  ArrivedSamples samples_;
  ReaderCursors readers_;
  PendingAck pending_ack_;
  bool awaited_ = false;
  bool overtakes_ = false;
};

template <class Accepts>
core::SampleHandle ArrivalWindow::next(core::EndpointId reader, const Accepts& accepts) {
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
    if (slot.state == State::begun && is_for_it) return {};
    ++place;
    if (is_for_it) return slot.sample;
  }
  return {};
}

}  // namespace sft::udp
