// A program on its own host that writes or reads numbered samples with some middleware. All contenders have
// the same interface, so that each group measures all of them.
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

using Contender = std::unique_ptr<Peer> (*)();
std::unique_ptr<Peer> sft_peer();
/// Bulk samples only. They are loaned from the publisher, and sent without a copy.
std::unique_ptr<Peer> sft_loan_peer();
/// With 4 MiB of receive buffer, as on a host whose administrator has not raised net.core.rmem_max beyond
/// that.
std::unique_ptr<Peer> sft_small_buffer_peer();
std::unique_ptr<Peer> cyclone_peer();
std::unique_ptr<Peer> fast_dds_peer();
// The following contenders have readers with callbacks only, and send from the first of two hosts to the
// second one.

/// Sends bulk samples as trains of datagrams by UDP GSO and GRO, with one acknowledgement for each sample;
/// write() waits for the acknowledgement of the sample before. Sends a datagram for each small sample, and
/// loses those that do not fit into the receiver's buffer.
std::unique_ptr<Peer> raw_udp_peer();
/// The same with a copy of each bulk sample, which reliable delivery needs if the writer may change its
/// memory.
std::unique_ptr<Peer> raw_udp_copying_peer();
/// Bulk samples only.
std::unique_ptr<Peer> raw_tcp_peer();
/// The same with a copy of each sample.
std::unique_ptr<Peer> raw_tcp_copying_peer();

}  // namespace sft::bench
