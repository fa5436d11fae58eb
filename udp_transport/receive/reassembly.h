// Makes samples from decoded datagrams. It finds the writer of each datagram among the writers that are read
// in this process. The class uses no clock, thread or I/O of its own.
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

  /// Sets the writers and requests from now on. Unfinished samples of a writer that is still read are kept;
  /// those of other writers are dropped. Writers with the same short id are distinguished by the addresses
  /// that their nodes announced, and by the announced properties of their samples.
  void set_streams(std::span<const Stream> streams);

  /// Accepts a datagram of a sample. The address from which it came matters only if several writers have the
  /// same short id. The mask's words are removed from `d`.
  Arrival accept(Datagram& d, const Envelope& envelope) { return accept_sample(d, d.label(), envelope); }
  Arrival accept(const Following& d, const Envelope& envelope) { return accept_sample(d, d.label, envelope); }
  Arrival accept(const Heartbeat& heartbeat, const Envelope& envelope);
  /// Counts a malformed datagram.
  void refuse(const Malformed& d);

  /// The multicast group that this process should join because of an offer.
  struct Joining {
    std::uint32_t group = 0;  ///< IPv4 address; 0: the offer withdrew the group
    bool anew = false;        ///< true if the group has to be joined again even if it was joined before
  };
  /// Accepts an offer. Returns nothing if no reader here reads the offer's writer. Otherwise groups() may
  /// have changed.
  std::optional<Joining> accept(const GroupOffer& offer, const Envelope& envelope);
  /// Processes a probe of a group. A probe of an unknown group is ignored; that group may be offered later.
  void accept(const GroupProbe& probe, const Envelope& envelope);
  /// Returns the IPv4 addresses of all groups that writers which are read in this process have offered.
  std::vector<std::uint32_t> groups() const;
  /// Sends the reports on groups that are due. Must be called after accept().
  void report_groups(const SendGroupReport& send);

  /// Returns the window of the stream; null unless the stream is reliable. The pointer is valid until
  /// set_streams().
  ArrivalWindow* window(std::size_t stream_index);
  /// Sends the acks that are due, with requests for missing parts. Must be called after accept(), and at the
  /// time that next_answer() returns.
  void answer(Time now, const SendAck& send);
  Time next_answer() const;

  /// Returns the address for a report to a process that has sent a flow mark. Returns nothing unless a
  /// writer of that process is read here.
  std::optional<SocketAddress> report_address(const core::IpAddress& from, std::uint16_t port) const;
  /// Notes that a sample or heartbeat of that stream came from this address. The writer's node may not have
  /// announced the address.
  void came_from(std::size_t stream_index, const core::IpAddress& ip);

  /// Drops samples that have made no progress for too long.
  void expire(Time now);
  /// Returns the earliest time at which expire() may drop a sample; empty if no sample is incomplete.
  std::optional<Time> next_expiry() const { return shared_.next_expiry(); }

  const Counters& counters() const { return shared_.counters; }

 private:
  struct Known {
    explicit Known(ReassemblyMemory& shared) : writer(shared) {}
    IncomingWriter writer;
    Known* twin = nullptr;  ///< the next writer with the same short id; null: there is none
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
  /// Releases the samples of the last datagram.
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
  /// By short id: the first of the writers with that id.
  std::unordered_map<std::uint32_t, Known*> by_short_id_;
  std::vector<IncomingWriter*> by_stream_;
  IncomingWriter* last_ = nullptr;  ///< writer of the last datagram, if its short id is unique
  /// The progress of the windows of writers that are not read any more. The newest entry is last.
  std::vector<std::pair<core::EndpointId, ArrivalWindow::Mark>> departed_;
  std::size_t windows_ = 0;  ///< number of reliable streams
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
