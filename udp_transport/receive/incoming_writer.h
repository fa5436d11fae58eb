// The receiving side of one writer. It makes samples and acks from the writer's decoded datagrams. Uses no
// clock, thread or I/O. Every datagram may be forged, so each value is checked, and memory is allocated only
// within limits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/seam/transport.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/multicast/offered_groups.h"
#include "udp_transport/receive/answer_path.h"
#include "udp_transport/receive/reassembly_memory.h"
#include "udp_transport/receive/recent_labels.h"
#include "udp_transport/receive/sample_assembly.h"
#include "udp_transport/receive/wanted_masks.h"
#include "udp_transport/reliable/arrival_window.h"
#include "udp_transport/reliable/sequence_monitor.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

/// A writer that is read in this process, and the selections that its readers request.
struct Stream {
  core::EndpointId writer = 0;
  const TypeSupport* type = nullptr;  ///< must outlive the stream
  std::size_t max_sample_bytes = 0;   ///< the maximum size that the writer announced; 0: not known
  std::vector<Selection> selections;
  bool reliable = false;   ///< true if some reader requests reliable delivery
  bool waits = false;      ///< true if the publisher waits for its reliable readers
  core::Announced node{};  ///< the writer's node; acks and reports are sent to its addresses
  bool alive = true;       ///< true if the node is alive, as far as this process knows
};

/// The address, time and length of a received datagram. Valid while the datagram is handled.
struct Envelope {
  const SocketAddress& from;
  ArrivalTime now;
  std::size_t bytes;  ///< length of the datagram in bytes
};

/// The samples that a datagram has made available to readers.
struct Arrival {
  core::SampleHandle sample;  ///< a whole and valid sample; null if the datagram completed none
  std::size_t stream = 0;     ///< the writer's index among the streams
  /// True if reliable readers may now get this sample, or other samples that have waited for their order.
  bool in_channel = false;
  /// The samples of a packed datagram, all of them whole and valid. The caller may move them. The span is
  /// valid until the next datagram.
  std::span<core::SampleHandle> packed{};
  /// True if these samples came by unicast, and an earlier sample may still be in the socket for groups.
  bool may_overtake = false;

  bool has_samples() const { return sample || !packed.empty(); }
  bool is_empty() const { return !in_channel && !has_samples(); }
};

class IncomingWriter {
 public:
  using Time = ReassemblyMemory::Time;

  /// `shared` must outlive this object.
  explicit IncomingWriter(ReassemblyMemory& shared) : shared_(shared), samples_(shared) {}

  /// Sets the requests of the writer's readers from now on.
  void follow(const Stream& stream, std::size_t stream_index);
  /// Opens the window of a reliable writer. `departed` is the progress of the writer's former window, if it
  /// had one.
  void open_window(const std::optional<ArrivalWindow::Mark>& departed);
  /// Closes the window and returns its progress. Returns nothing if the window was not open, or no datagram
  /// of the channel has come.
  std::optional<ArrivalWindow::Mark> close_window();

  /// The properties of the writer.
  struct Facts {
    core::EndpointId id = 0;
    const TypeSupport* type = nullptr;
    std::size_t stream_index = 0;
    bool alive = true;             ///< true if the writer's node is alive
    std::size_t sample_bytes = 0;  ///< the maximum size in bytes of an accepted body
    core::Announced node{};
    /// The address from which the last sample came. The node may not have announced it.
    core::IpAddress came_from{};

    std::uint32_t short_id() const { return static_cast<std::uint32_t>(id); }
  };
  const Facts& facts() const { return facts_; }
  void set_came_from(const core::IpAddress& ip) { facts_.came_from = ip; }
  /// Returns the window; null unless some reader requests reliable delivery.
  ArrivalWindow* window() { return window_.get(); }

  // The following functions return true if the datagram can be from this writer. They are needed because
  // several writers may have the same short id.

  bool fits(const Following& d) const { return samples_.find(d.label) != nullptr; }
  bool fits(const Datagram& d);
  bool follows(std::uint32_t channel) const;

  /// Accepts a datagram of a sample. Removes the mask's words from `d`, and sets the ordinal in the channel
  /// of a sample that came by a group.
  Arrival accept(Datagram& d, const Envelope& envelope);
  Arrival accept(const Following& d, const Envelope& envelope);
  /// Accepts a heartbeat. From now on, acks are sent to `answers_to`.
  Arrival accept(const Heartbeat& heartbeat, const SocketAddress& answers_to, const Envelope& envelope);

  /// Drops samples that have made no progress for too long. Sets `next` to the time when the next sample may
  /// be dropped, if that is earlier.
  void expire(Time now, std::optional<Time>& next) { samples_.expire(now, next); }
  /// Sends the acks that are due, with requests for missing parts.
  void answer(Time now, const SendAck& send);
  /// Returns the earliest time at which answer() will request missing parts. Returns Time::max() if no part
  /// is missing, or if no part may be requested until more datagrams of the writer have come.
  Time next_answer() const {
    const bool may_ask = window_ != nullptr && answers_.is_known() && answers_.parts_covered() > 0;
    return may_ask ? window_->next_look() : Time::max();
  }
  /// Returns the multicast groups that the writer has offered.
  OfferedGroups& groups() { return groups_; }

 private:
  enum class Refusal : std::uint8_t { none, malformed, unwanted, over_limit };

  Arrival accept_first(const Datagram& d, const WantedMasks::Named& named, ArrivalTime now,
                       bool same_datagram = false);
  Arrival accept_packed(const Datagram& packed, const WantedMasks::Named& named, ArrivalTime now);
  bool place_by_group(Datagram& d, Time now);
  Arrival begin(const Datagram& d, UnfinishedSample* sample, std::uint64_t place, core::SampleHandle buffer,
                ArrivalTime now);
  Arrival proceed(UnfinishedSample& sample, UnfinishedSample::Added added, ArrivalTime now);
  Arrival complete(core::SampleHandle sample, const FirstHeader& first, std::uint64_t place, ArrivalTime now);
  bool accepts(const SequenceMonitor::Observed& observed, Time now);

  Refusal describe(const Datagram& d, const WantedMasks::Named& named, std::uint64_t place,
                   core::SampleHandle& buffer);
  core::SampleHandle take_buffer(const Datagram& d, std::uint64_t place);
  std::size_t reserved_for_first_missing() const;
  Arrival refuse(const Datagram& d, std::uint64_t place, Refusal why, Time now);
  void drop(const SampleLabel& label, std::uint64_t& counter);
  void drop_abandoned();

  ReassemblyMemory& shared_;
  Facts facts_;
  WantedMasks wanted_;
  SequenceMonitor sequences_;  ///< checks the sequences of completed samples
  SampleAssembly samples_;
  std::unique_ptr<ArrivalWindow> window_;
  AnswerPath answers_;
  OfferedGroups groups_;
  RecentLabels elsewhere_;  ///< samples of groups that were not offered; they also come by unicast
};

}  // namespace sft::udp
