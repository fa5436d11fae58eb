// Makes samples of decoded datagrams: it finds the writer of each datagram among those that are read here.
// The class is pure: datagrams and times go in, samples come out; it has no I/O, no clock and no thread of
// its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/seam/buffer_pool.h"
#include "core/seam/transport.h"
#include "udp_transport/receive/incoming_writer.h"
#include "udp_transport/receive/reassembly_memory.h"

namespace sft::udp {

class Reassembly {
 public:
  using Time = ReassemblyMemory::Time;
  using Counters = core::Transport::Counters;
  using SendGroupReport = std::function<void(const SocketAddress&, const GroupReport&)>;

  Reassembly(const ReassemblyLimits& limits, std::shared_ptr<core::BufferPool> pool);

  /// Sets what is wanted from now on. The unfinished samples of a writer that stays are kept, and those of
  /// one that goes are dropped. Writers whose short ids are equal are told apart by the addresses that their
  /// nodes announced, and by what they announced of their samples.
  void set_streams(std::span<const Stream> streams);

  /// The address that the datagram came from matters only where writers have equal short ids. The mask's
  /// words are taken off the datagram.
  Arrival accept(Datagram& d, const Envelope& envelope) { return accept_sample(d, d.label(), envelope); }
  Arrival accept(const Following& d, const Envelope& envelope) { return accept_sample(d, d.label, envelope); }
  Arrival accept(const Heartbeat& heartbeat, const Envelope& envelope);
  /// Counts a datagram that makes no sense.
  void refuse(const Malformed& d);

  /// The request of an offer.
  struct Joining {
    std::uint32_t group = 0;  ///< IPv4; 0: the offer took its group back
    bool anew = false;        ///< join the group again, even if it was joined before
  };
  /// Empty if the offer is of a writer that nobody reads. Otherwise groups() may have changed.
  std::optional<Joining> accept(const GroupOffer& offer, const Envelope& envelope);
  /// A probe that leads nowhere is ignored: the group may be offered later.
  void accept(const GroupProbe& probe, const Envelope& envelope);
  /// The IPv4 addresses of all groups that were offered by writers that are read here.
  std::vector<std::uint32_t> groups() const;
  /// Sends what writers have to know of their groups. Called after accept().
  void report_groups(const SendGroupReport& send);

  /// Null unless the stream is reliable. Valid until set_streams().
  ArrivalWindow* window(std::size_t stream_index);
  /// Sends what is to be acknowledged or asked for by now. Called after accept(), and at next_answer().
  void answer(Time now, const SendAck& send);
  Time next_answer() const;

  /// Returns where to report to a process that marks what it sends, if a writer that is read here belongs to
  /// it.
  std::optional<SocketAddress> report_address(const core::IpAddress& from, std::uint16_t port) const;
  /// Something of that stream came from this address, which its node need not have announced.
  void came_from(std::size_t stream_index, const core::IpAddress& ip);

  /// Drops what has made no progress for too long.
  void expire(Time now);
  /// The earliest time when expire() has something to do; empty while nothing has begun.
  std::optional<Time> next_expiry() const { return shared_.next_expiry(); }

  const Counters& counters() const { return shared_.counters; }

 private:
  struct Known {
    explicit Known(ReassemblyMemory& shared) : writer(shared) {}
    IncomingWriter writer;
    Known* twin = nullptr;  ///< the next writer with the same short id
  };

  template <class Fits>
  IncomingWriter* find(std::uint32_t short_id, const core::IpAddress& from, const Fits& fits);
  IncomingWriter* writer_of(const Datagram& d, const core::IpAddress& from);
  IncomingWriter* writer_of(const Following& d, const core::IpAddress& from);
  template <class SampleDatagram>
  Arrival accept_sample(SampleDatagram& d, const SampleLabel& label, const Envelope& envelope);
  bool is_of_last(std::uint32_t short_id) const {
    return last_ != nullptr && last_->facts().short_id() == short_id;
  }
  /// Lets go of what the last datagram brought.
  void begin_datagram() {
    shared_.packed.clear();
    shared_.pack_buffers.clear();
    ++shared_.datagrams;
  }
  void note_short_ids(std::span<const Stream> streams);
  void set_window(IncomingWriter& writer, const Stream& stream);
  void close_window(IncomingWriter& writer);

  ReassemblyMemory shared_;
  std::unordered_map<core::EndpointId, std::unique_ptr<Known>> writers_;
  std::unordered_map<std::uint32_t, Known*> by_short_id_;  ///< the first of those that have the short id
  std::vector<IncomingWriter*> by_stream_;
  IncomingWriter* last_ = nullptr;  ///< the writer of the last datagram, if no other one has its short id
  /// The progress of the windows of writers that are no longer read, the newest last.
  std::vector<std::pair<core::EndpointId, ArrivalWindow::Mark>> departed_;
  std::size_t windows_ = 0;  ///< counts the reliable streams
};

template <class SampleDatagram>
Arrival Reassembly::accept_sample(SampleDatagram& d, const SampleLabel& label, const Envelope& envelope) {
  begin_datagram();
  IncomingWriter* const writer = is_of_last(label.writer) ? last_ : writer_of(d, envelope.from.ip);
  if (writer != nullptr) [[likely]]
    return writer->accept(d, envelope);
  ++shared_.counters.unknown;
  return {};
}

}  // namespace sft::udp
