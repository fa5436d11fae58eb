// From datagrams to samples. Pure: bytes and times in, samples out; no I/O, no clock, no thread of its own.
// Every byte may be hostile: nothing is taken for granted, and nothing is allocated but within the limits.
#pragma once

#include <chrono>
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
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/receive/unfinished_samples.h"
#include "udp_transport/receive/wanted_masks.h"
#include "udp_transport/reliable/arrival_window.h"
#include "udp_transport/reliable/sequence_watch.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

struct ReassemblyLimits {
  std::size_t sample_bytes = std::size_t{64} << 20;       ///< of one body, whatever its writer announced
  std::size_t unfinished_bytes = std::size_t{128} << 20;  ///< of bodies of one writer that have begun
  std::size_t unfinished_per_variant = 4;                 ///< samples
  std::size_t unfinished_per_writer = 32;                 ///< samples
  std::size_t parked_bytes = std::size_t{512} << 10;      ///< of all datagrams that overtook their first
  std::size_t gaps = 4096;                                ///< in one sample
  std::chrono::milliseconds patience{500};                ///< without progress
  ArrivalLimits channel{};                                ///< of what one writer sends reliably
};

/// A writer whose samples are wanted here, and under which masks.
struct Stream {
  core::EndpointId writer = 0;
  const TypeSupport* type = nullptr;  ///< outlives the stream
  std::size_t max_sample_bytes = 0;   ///< announced by the writer; 0: not known
  std::vector<FieldMask> masks;
  bool reliable = false;   ///< some reader wants it to be
  bool waits = false;      ///< its publisher does, for these
  core::Announced node{};  ///< where acks and reports may go
  bool alive = true;       ///< as far as its node tells
};

class Reassembly {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Counters = core::Transport::Counters;

  struct Arrival {
    core::SampleHandle sample;  ///< whole and valid; empty if the datagram completed none
    std::size_t stream = 0;     ///< its place in what was given to set_streams()
    bool in_channel = false;    ///< readers may now have something in order, this sample or others
    /// Likewise whole and valid, of a packed datagram; may be taken out, and is gone with the next call.
    std::span<core::SampleHandle> packed{};
  };
  using SendAck = std::function<void(const SocketAddress&, const Ack&)>;

  Reassembly(const ReassemblyLimits& limits, std::shared_ptr<core::BufferPool> pool);
  ~Reassembly();

  /// What is wanted from now on. What has begun of a writer that stays is kept, and of one that goes is
  /// dropped. Writers whose short ids are equal are told apart by the addresses that their nodes announced,
  /// and by what they announced of their samples.
  void set_streams(std::span<const Stream> streams);

  /// `from`: where the datagram came from; it matters only where writers have equal short ids.
  Arrival accept(std::span<const std::byte> datagram, ArrivalTime now, const core::IpAddress& from = {});

  Arrival accept_heartbeat(std::span<const std::byte> datagram, SocketAddress from, ArrivalTime now);

  /// What an offer asks for.
  struct Joining {
    std::uint32_t group = 0;  ///< IPv4; 0: none, it was taken back
    bool anew = false;        ///< also if it was joined before
  };
  /// Empty if it is of nobody who is wanted here. Else groups() may be others than before.
  std::optional<Joining> accept_offer(std::span<const std::byte> datagram, SocketAddress from,
                                      ArrivalTime now);
  /// Those that were offered to who is wanted here, IPv4.
  std::vector<std::uint32_t> groups() const;
  using SendReport = std::function<void(const SocketAddress&, const GroupReport&)>;
  /// What writers are to be told of their groups. After accept().
  void report(const SendReport& send);

  /// Of a stream that is reliable; else null. Valid until set_streams().
  ArrivalWindow* window(std::size_t stream);
  /// Sends what is to be acknowledged or asked for by now. After accept(), and by next_answer().
  void answer(Time now, const SendAck& send);
  Time next_answer() const;

  /// Where to report to whoever marks what it sends, if that is a writer that is wanted here.
  std::optional<SocketAddress> report_address(const core::IpAddress& from, std::uint16_t port) const;
  /// Something of that stream came from there: it may not be an address that was announced.
  void came_from(std::size_t stream, const core::IpAddress& ip);

  /// Drops what has made no progress for too long.
  void expire(Time now);
  /// When expire() has something to do at the earliest; empty while nothing has begun.
  std::optional<Time> next_expiry() const { return next_expiry_; }

  const Counters& counters() const { return counters_; }

 private:
  struct Incoming;  ///< what is known of one writer
  enum class Refusal : std::uint8_t { none, malformed, unwanted, over_limit };

  /// Null if nobody here wants it. `fits(in)`: whether it can be of that one, if several have that short id.
  template <class Fits>
  Incoming* find(std::uint32_t writer, const core::IpAddress& from, const Fits& fits);
  static bool fits(Incoming& in, const std::optional<Datagram>& d, const std::optional<Following>& following);
  Arrival accept_first(Incoming& in, const Datagram& d, const WantedMasks::Named& named, ArrivalTime now,
                       bool same_datagram = false);
  Arrival accept_packed(Incoming& in, const Datagram& d, const WantedMasks::Named& named, ArrivalTime now);
  bool gives_way(Incoming& in, std::uint64_t place, const SampleLabel& label, Time now);
  void join_channel(Incoming& in, UnfinishedSample& sample, std::uint64_t place);
  bool place(Incoming& in, Datagram& d, Time now);
  Arrival accept_following(Incoming& in, const Following& d, ArrivalTime now);
  Arrival proceed(Incoming& in, UnfinishedSample& sample, UnfinishedSample::Added added, ArrivalTime now);
  Arrival complete(Incoming& in, core::SampleHandle sample, const FirstHeader& first, std::uint64_t place,
                   ArrivalTime now);
  bool believes(Incoming& in, const SequenceWatch::Claim& claim, Time now);
  void park(Incoming& in, UnfinishedSample& sample, const Following& d, Time now);

  Arrival refuse(Incoming& in, const Datagram& d, std::uint64_t place, Refusal why);
  void drop_abandoned(Incoming& in);
  void answer(Incoming& in, Time now, const SendAck& send);

  void note_short_ids(std::span<const Stream> streams);
  void open_window(Incoming& in);
  void close_window(Incoming& in);

  Refusal describe(Incoming& in, const Datagram& d, const WantedMasks::Named& named, std::uint64_t place,
                   core::SampleHandle& buffer);
  core::SampleHandle take_buffer(Incoming& in, const Datagram& d);
  core::SampleHandle take_reliable_buffer(Incoming& in, const Datagram& d, std::uint64_t place);
  std::size_t left_for_first_missing(const Incoming& in) const;

  UnfinishedSample& begin(Incoming& in, const SampleLabel& label, std::uint64_t place, Time now);
  bool drop_oldest(Incoming& in, const SampleLabel& same_variant_first);
  void drop(Incoming& in, const SampleLabel& label, std::uint64_t& counter);
  void keep_spare(std::unique_ptr<UnfinishedSample> sample);
  std::unique_ptr<UnfinishedSample> remove(Incoming& in, const SampleLabel& label);

  ReassemblyLimits limits_;
  std::shared_ptr<core::BufferPool> pool_;
  std::unordered_map<core::EndpointId, std::unique_ptr<Incoming>> incoming_;
  std::unordered_map<std::uint32_t, Incoming*> by_short_id_;  ///< the first of those that have it
  std::vector<Incoming*> by_stream_;
  Incoming* last_ = nullptr;  ///< whose datagram came last; nobody who shares its short id
  std::vector<std::pair<core::EndpointId, ArrivalWindow::Mark>>
      left_;                                              ///< writers that were, the newest last
  std::size_t windows_ = 0;                               ///< streams that are reliable
  std::vector<std::unique_ptr<UnfinishedSample>> spare_;  ///< kept for the memory that they hold
  std::vector<core::SampleHandle> packed_;                ///< of the last packed datagram
  std::vector<core::SampleHandle> ahead_;                 ///< for the rest of a packed datagram
  std::uint64_t datagrams_ = 0;                           ///< that came
  std::size_t unfinished_ = 0;
  std::size_t parked_bytes_ = 0;
  bool reports_due_ = false;
  std::optional<Time> next_expiry_;
  Counters counters_;
};

}  // namespace sft::udp
