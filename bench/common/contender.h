// A program that writes or reads samples with some middleware. All contenders have the same interface, so
// that each benchmark measures all of them.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "bench/common/pair.h"

namespace sft::bench {

class Messages;

/// A function that is called with the number of each sample after the sample was read.
using Arrived = std::function<void(std::uint64_t)>;

/// A set of top-level fields of a message: bit i stands for its i-th member.
using FieldSet = std::uint32_t;
constexpr FieldSet all_fields(std::size_t fields) { return (FieldSet{1} << fields) - 1; }

/// The fields that SFT's readers of messages request. Readers of other contenders get all fields.
struct Wanted {
  std::optional<std::string> fields{};  ///< the fields as text; empty: all fields
  bool recorded = false;                ///< true: SFT records which fields the program reads
  FieldSet read = 0;                    ///< the fields of each message that the program reads
};

struct Topic {
  std::string name = "samples";
  std::uint32_t bulk_bytes = 0;  ///< number of data bytes in each sample; 0: whole samples have 64 bytes
  /// Messages to send in turns, in place of samples that contain a number.
  std::shared_ptr<const Messages> messages{};
  bool reliable = true;
  bool durable = false;     ///< true: late readers get the last sample, too, and delivery is reliable
  std::uint32_t depth = 8;  ///< the number of samples that a writer and a reader keep
  /// True: Reader::wait() spins until a sample arrives, if the contender supports that.
  bool spinning = false;
  bool batching = false;  ///< true: samples that are written together may share datagrams

  /// True: SFT's readers request only the number and the stamp, and not the data.
  bool two_fields = false;
  Wanted wanted{};
  std::optional<std::chrono::nanoseconds> spin{};  ///< SubscriberOptions::spin of SFT's readers
  // The following members are for contenders without discovery and names.
  std::uint16_t id = 0;     ///< the number of the topic, unique and less than 64
  std::size_t readers = 1;  ///< the number of readers of the writer, at most 16
  std::size_t reader = 0;   ///< the index of this reader
  /// True: the reader is on the writer's host; false: each reader is on a host of its own.
  bool on_one_host = false;
};

class Writer {
 public:
  Writer() = default;
  virtual ~Writer() = default;
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Returns the number of readers that get the samples that are written from now on.
  virtual std::size_t readers() const = 0;
  virtual bool serves(std::size_t count) const { return readers() == count; }
  /// Writes the sample with this number. For a topic with messages, writes the message with this number.
  virtual void write(std::uint64_t number) = 0;
  /// Writes the samples [first, first + count).
  virtual void write_together(std::uint64_t first, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) write(first + i);
  }
  // The two steps of write(). A contender that lends memory takes the memory in the first step.
  virtual void prepare(std::uint64_t number) { prepared_ = number; }
  virtual void publish() { write(prepared_); }

 private:
  std::uint64_t prepared_ = 0;
};

/// A writer that lends memory for each sample.
class LendingWriter : public Writer {
 public:
  void write(std::uint64_t number) final {
    prepare(number);
    publish();
  }
  void prepare(std::uint64_t number) override = 0;
  void publish() override = 0;
};

class Reader {
 public:
  Reader() = default;
  virtual ~Reader() = default;
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  virtual std::size_t writers() const = 0;
  // The following functions are only for a reader without a callback.
  virtual void wait() {}  ///< waits at most a second for a sample
  /// Returns the number of the next sample; 0: no sample has arrived.
  virtual std::uint64_t take() { return 0; }
};

/// The participants of one process. The object must outlive its writers and readers.
class Peer {
 public:
  Peer() = default;
  virtual ~Peer() = default;
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  virtual std::unique_ptr<Writer> writer(const Topic& topic) = 0;
  /// Opens a reader. It calls `arrived` on a thread of the contender, with the number of the sample, or
  /// with 0 if the sample is a message without a number. Without `arrived`, the caller takes the samples.
  virtual std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived = {}) = 0;
  /// Waits until the topic's writer in another process is known.
  virtual void know_writer(const Topic& /*topic*/) {}
};

inline constexpr std::uint32_t sent_cloud_bytes = 6'291'456;  ///< the data of 393,216 points of 16 bytes
/// The time after which iceoryx has connected all ports. iceoryx connects ports every 100 ms.
inline constexpr std::int64_t iceoryx_connecting_us = 300'000;

using Contender = std::unique_ptr<Peer> (*)();
std::unique_ptr<Peer> sft_peer();
/// Returns SFT for bulk samples only. Samples are loaned from the publisher, and sent without a copy.
std::unique_ptr<Peer> sft_loan_peer();
std::unique_ptr<Peer> cyclone_peer();
std::unique_ptr<Peer> fast_dds_peer();

// The following contenders have their default settings. Writers of SFT do not wait for readers, and writers
// of DDS wait for at most a second. Writers and readers keep only the last samples.

std::unique_ptr<Peer> sft_usual_peer();    ///< uses UDP
std::unique_ptr<Peer> sft_unicast_peer();  ///< uses UDP without multicast
std::unique_ptr<Peer> sft_local_peer();    ///< uses shared memory, and UDP to other hosts
std::unique_ptr<Peer> cyclone_usual_peer();
std::unique_ptr<Peer> cyclone_unicast_peer();
/// Returns Cyclone DDS with `config` as its configuration.
std::unique_ptr<Peer> cyclone_peer_with(const std::string& config);
std::unique_ptr<Peer> fast_dds_usual_peer();
std::unique_ptr<Peer> fast_dds_multicast_peer();
/// Returns Fast DDS that also uses shared memory. The memory has room for several samples of 6.3 MB. With the
/// default size, which is less than a tenth of such a sample, no sample would arrive.
std::unique_ptr<Peer> fast_dds_local_peer();

// The following contenders pass samples in shared memory.

std::unique_ptr<Peer> sft_memory_peer();
/// Returns SFT for bulk samples only, in loans.
std::unique_ptr<Peer> sft_memory_loan_peer();
/// Returns SFT with point clouds as bulk samples, in loans. The clouds have the requested number of data
/// bytes, and readers read two fields of the clouds.
std::unique_ptr<Peer> sft_cloud_loan_peer();
/// Returns Cyclone DDS over iceoryx, which connects within iceoryx_connecting_us after writers and readers
/// have found each other. REQUIRES: the process has entered the namespace of a Roudi.
std::unique_ptr<Peer> cyclone_memory_peer();
std::unique_ptr<Peer> fast_dds_memory_peer();
/// Returns iceoryx alone, which copies each sample into a loan. For bulk samples only, and for readers
/// without a callback. REQUIRES: sftd runs.
std::unique_ptr<Peer> iceoryx_peer();
/// Returns iceoryx alone with a loan of which only the number is written.
std::unique_ptr<Peer> iceoryx_loan_peer();

// The following contenders are sockets.

/// Returns a contender that sends bulk samples as trains of datagrams by UDP GSO and GRO, with one
/// acknowledgement for each sample. write() waits for the acknowledgement of the previous sample, or of an
/// earlier sample if samples are small. A sample that is not bulk is sent as one datagram, and is lost if
/// it does not fit into the receiver's buffer.
std::unique_ptr<Peer> raw_udp_peer();
/// Returns the contender of raw_udp_peer() that also copies each bulk sample. Reliable delivery needs the
/// copy if the writer may change its memory.
std::unique_ptr<Peer> raw_udp_copying_peer();
/// Returns a contender that sends samples over TCP. For bulk samples only.
std::unique_ptr<Peer> raw_tcp_peer();

}  // namespace sft::bench
