// A program that writes or reads numbered samples with some middleware. All contenders have the same
// interface, so that each group measures all of them.
#pragma once

#include <cstdint>
#include <memory>

#include "bench/common/transfer.h"

namespace sft::bench {

struct Topic {
  const char* name = "samples";
  std::uint32_t bulk_bytes = 0;  ///< bytes of data in each sample; 0: whole samples have 64 bytes
  bool reliable = true;
  std::uint32_t depth = 8;  ///< samples that either side keeps
  bool spinning = false;    ///< Reader::wait() keeps its core busy until a sample comes, if it can
  bool batching = false;    ///< samples that are written together may share datagrams

  /// SFT's readers ask for the number and the stamp only, and not for the data.
  bool two_fields = false;
  /// SFT's readers do not spin before they sleep (SubscriberOptions::spin is 0).
  bool sleeps_at_once = false;
  // For contenders that have neither discovery nor names:
  std::uint16_t id = 0;      ///< a topic of its own; below 64
  std::size_t readers = 1;   ///< of the writer, at most 16
  std::size_t reader = 0;    ///< the number of this reader
  bool on_one_host = false;  ///< all readers are on the writer's host; otherwise each is on the next one
};

class Writer {
 public:
  virtual ~Writer() = default;
  virtual std::size_t readers() const = 0;
  virtual void write(std::uint64_t number) = 0;
  /// Writes the samples [first, first + count).
  virtual void write_together(std::uint64_t first, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) write(first + i);
  }
};

class Reader {
 public:
  virtual ~Reader() = default;
  virtual std::size_t writers() const = 0;
  // Only for a reader without a callback:
  virtual void wait() {}                      ///< waits for a sample to take, for a second at most
  virtual std::uint64_t take() { return 0; }  ///< the number of the next sample; 0: there is none
};

/// The participants of one process. It outlives its writers and readers.
class Peer {
 public:
  virtual ~Peer() = default;
  virtual std::unique_ptr<Writer> writer(const Topic& topic) = 0;
  /// Calls `arrived` on a thread of the contender. Without it, the caller takes samples.
  virtual std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived = {}) = 0;
};

inline constexpr std::int64_t iceoryx_connecting_us = 300'000;  ///< it connects ports every 100 ms

using Contender = std::unique_ptr<Peer> (*)();
std::unique_ptr<Peer> sft_peer();
/// Bulk samples only. They are loaned from the publisher, and sent without a copy.
std::unique_ptr<Peer> sft_loan_peer();
/// With 4 MiB of receive buffer, as on a host whose administrator has not raised net.core.rmem_max beyond
/// that.
std::unique_ptr<Peer> sft_small_buffer_peer();
std::unique_ptr<Peer> cyclone_peer();
std::unique_ptr<Peer> fast_dds_peer();

// The following contenders pass samples in shared memory.

std::unique_ptr<Peer> sft_memory_peer();
/// Bulk samples only.
std::unique_ptr<Peer> sft_memory_loan_peer();
/// Over iceoryx, which takes iceoryx_connecting_us after writers and readers have found each other. REQUIRES:
/// the process has entered the namespace of a Roudi.
std::unique_ptr<Peer> cyclone_memory_peer();
std::unique_ptr<Peer> fast_dds_memory_peer();
/// iceoryx alone: a loan into which each sample is copied. Bulk samples only, and readers without a callback.
/// REQUIRES: sftd runs.
std::unique_ptr<Peer> iceoryx_peer();
/// The same with a loan of which only the number is written.
std::unique_ptr<Peer> iceoryx_loan_peer();

// The following contenders are sockets.

/// Sends bulk samples as trains of datagrams by UDP GSO and GRO, with one acknowledgement for each sample;
/// write() waits for the acknowledgement of the sample before, or of an earlier one if samples are small.
/// Sends a datagram for each sample that is not bulk, and loses those that do not fit into the receiver's
/// buffer.
std::unique_ptr<Peer> raw_udp_peer();
/// The same with a copy of each bulk sample, which reliable delivery needs if the writer may change its
/// memory.
std::unique_ptr<Peer> raw_udp_copying_peer();
/// Bulk samples only.
std::unique_ptr<Peer> raw_tcp_peer();
/// The same with a copy of each sample.
std::unique_ptr<Peer> raw_tcp_copying_peer();

}  // namespace sft::bench
