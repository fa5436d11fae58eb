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

/// Called with the number of each sample after it was read.
using Arrived = std::function<void(std::uint64_t)>;

/// Top-level fields of a message: bit i is its i-th member.
using FieldSet = std::uint32_t;
constexpr FieldSet all_fields(std::size_t fields) { return (FieldSet{1} << fields) - 1; }

/// What SFT's readers of messages ask for. Readers of other contenders get all fields.
struct Wanted {
  std::optional<std::string> fields{};  ///< as text; nothing: all
  bool recorded = false;                ///< SFT finds out which fields the program reads
  FieldSet read = 0;                    ///< the program reads these of each message
};

struct Topic {
  std::string name = "samples";
  std::uint32_t bulk_bytes = 0;  ///< bytes of data in each sample; 0: whole samples have 64 bytes
  /// These are sent, by their numbers, in place of samples that have a number in them.
  std::shared_ptr<const Messages> messages{};
  bool reliable = true;
  bool durable = false;     ///< late readers get the last sample, too, which is delivered reliably
  std::uint32_t depth = 8;  ///< samples that either side keeps
  bool spinning = false;    ///< Reader::wait() keeps its core busy until a sample comes, if it can
  bool batching = false;    ///< samples that are written together may share datagrams

  /// SFT's readers ask for the number and the stamp only, and not for the data.
  bool two_fields = false;
  Wanted wanted{};
  std::optional<std::chrono::nanoseconds> spin{};  ///< SubscriberOptions::spin of SFT's readers
  // For contenders that have neither discovery nor names:
  std::uint16_t id = 0;      ///< a topic of its own; below 64
  std::size_t readers = 1;   ///< of the writer, at most 16
  std::size_t reader = 0;    ///< the number of this reader
  bool on_one_host = false;  ///< all readers are on the writer's host; otherwise each is on the next one
};

class Writer {
 public:
  Writer() = default;
  virtual ~Writer() = default;
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// The number of readers that get what is written from now on.
  virtual std::size_t readers() const = 0;
  virtual bool serves(std::size_t count) const { return readers() == count; }
  /// Writes the sample with this number or, of a topic with messages, this one of them.
  virtual void write(std::uint64_t number) = 0;
  /// Writes the samples [first, first + count).
  virtual void write_together(std::uint64_t first, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) write(first + i);
  }
  // The two steps of write(). A contender that lends memory takes it in the first one.
  virtual void prepare(std::uint64_t number) { prepared_ = number; }
  virtual void publish() { write(prepared_); }

 private:
  std::uint64_t prepared_ = 0;
};

/// Lends memory for each sample.
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
  // Only for a reader without a callback:
  virtual void wait() {}                      ///< waits for a sample to take, for a second at most
  virtual std::uint64_t take() { return 0; }  ///< the number of the next sample; 0: there is none
  /// From then on SFT's reader of messages gets these fields, and no others.
  virtual void ask_for(const std::string& /*fields*/) {}
};

/// The participants of one process. It outlives its writers and readers.
class Peer {
 public:
  Peer() = default;
  virtual ~Peer() = default;
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  virtual std::unique_ptr<Writer> writer(const Topic& topic) = 0;
  /// Calls `arrived` on a thread of the contender, with the number of a sample, or 0 of a message. Without
  /// it, the caller takes samples.
  virtual std::unique_ptr<Reader> reader(const Topic& topic, Arrived arrived = {}) = 0;
  /// Waits until the topic's writer in another process is known.
  virtual void know_writer(const Topic& /*topic*/) {}
};

inline constexpr std::uint32_t sent_cloud_bytes = 6'291'456;    ///< data of 393,216 points of 16 bytes
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

// The following contenders have their default settings. Writers of SFT do not wait for readers, and those of
// DDS do so for at most a second. Both sides keep the last samples only.

std::unique_ptr<Peer> sft_usual_peer();    ///< over UDP
std::unique_ptr<Peer> sft_unicast_peer();  ///< the same without multicast
std::unique_ptr<Peer> sft_local_peer();    ///< in shared memory, and over UDP to other hosts
std::unique_ptr<Peer> cyclone_usual_peer();
std::unique_ptr<Peer> cyclone_unicast_peer();
/// Cyclone DDS with the text of a configuration.
std::unique_ptr<Peer> cyclone_peer_with(const std::string& config);
std::unique_ptr<Peer> fast_dds_usual_peer();
std::unique_ptr<Peer> fast_dds_multicast_peer();
/// Also in shared memory, which has room for several samples of 6.3 MB: the default is less than a tenth of
/// one, with which none arrives.
std::unique_ptr<Peer> fast_dds_local_peer();

// The following contenders pass samples in shared memory.

std::unique_ptr<Peer> sft_memory_peer();
/// Bulk samples only.
std::unique_ptr<Peer> sft_memory_loan_peer();
/// Bulk samples are point clouds with so many bytes of data, of which readers read two fields.
std::unique_ptr<Peer> sft_cloud_peer();
/// The same, in loans.
std::unique_ptr<Peer> sft_cloud_loan_peer();
/// Over iceoryx, which takes iceoryx_connecting_us after writers and readers have found each other. REQUIRES:
/// the process has entered the namespace of a Roudi.
std::unique_ptr<Peer> cyclone_memory_peer();
/// The same in loans of samples of fixed size, with sent_cloud_bytes of data.
std::unique_ptr<Peer> cyclone_memory_loan_peer();
std::unique_ptr<Peer> fast_dds_memory_peer();
/// In such loans by data sharing, in which readers see the writer's memory.
std::unique_ptr<Peer> fast_dds_memory_loan_peer();
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
/// The least that a publisher and its readers do over UDP without IP fragments: a message goes to one
/// multicast group in datagrams that fit into packets, and each reader reads all of them. What gets lost
/// stays lost, and nobody looks at a message. Topics with messages only.
std::unique_ptr<Peer> raw_multicast_peer();

}  // namespace sft::bench
