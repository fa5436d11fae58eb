// A program on a host of its own that writes or reads numbered samples, with whatever middleware: the same
// words for all contenders, so that each question is put to all of them.
#pragma once

#include <cstdint>
#include <memory>

#include "bench/common/transfer.h"

namespace sft::bench {

struct Topic {
  const char* name = "samples";
  std::uint32_t bulk_bytes = 0;  ///< of data in each sample; 0: samples of 64 bytes in all
  bool reliable = true;
  std::uint32_t depth = 8;  ///< samples that either side keeps
  bool spinning = false;    ///< Reader::wait() keeps its core busy until a sample comes, if it can
  bool batching = false;    ///< what is written together may travel together
};

class Writer {
 public:
  virtual ~Writer() = default;
  virtual std::size_t readers() const = 0;
  virtual void write(std::uint64_t number) = 0;
  /// [first, first + count)
  virtual void write_together(std::uint64_t first, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) write(first + i);
  }
};

class Reader {
 public:
  virtual ~Reader() = default;
  virtual std::size_t writers() const = 0;
  // Of a reader without a callback:
  virtual void wait() {}                      ///< until there is something to take, for a second at most
  virtual std::uint64_t take() { return 0; }  ///< the number of the next sample; 0: there is none
};

/// The participants of one process; writers and readers end before it does.
class Peer {
 public:
  virtual ~Peer() = default;
  virtual std::unique_ptr<Writer> writer(const Topic& topic) = 0;
  /// `arrived` is called on a thread of the contender's; without it samples are taken.
  virtual std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived = {}) = 0;
};

using Contender = std::unique_ptr<Peer> (*)();
std::unique_ptr<Peer> sft_peer();
/// Bulk samples only: loaned from the publisher, and sent without a copy of them.
std::unique_ptr<Peer> sft_loan_peer();
std::unique_ptr<Peer> cyclone_peer();
std::unique_ptr<Peer> fast_dds_peer();
// For called readers only, from the first of two hosts to the second one:
/// Bulk samples: trains of datagrams by UDP GSO and GRO, and one acknowledgement for each sample; write()
/// waits for that of the one before. Small ones: a datagram each, and what the receiver has no room for is
/// lost.
std::unique_ptr<Peer> raw_udp_peer();
/// The same, and each bulk sample is copied first: what is reliable, and its writer may write to again, is
/// kept so.
std::unique_ptr<Peer> raw_udp_copying_peer();
/// Bulk samples only.
std::unique_ptr<Peer> raw_tcp_peer();
/// The same, and each is copied first.
std::unique_ptr<Peer> raw_tcp_copying_peer();

}  // namespace sft::bench
