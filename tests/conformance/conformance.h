// The helpers of the conformance suite: a writer on one node, and readers on another node, which sleep until
// their transport wakes them. These helpers never poll for samples, so a lost wake-up fails a test.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/platform/doorbell.h"
#include "core/seam/buffer_pool.h"
#include "core/seam/transport.h"
#include "tests/conformance/medium.h"
#include "tests/support/eventually.h"
#include "tests/support/test_seed.h"
#include "tests/unit/udp/messages.h"

namespace sft::conformance {

using test::eventually;
using test::hang_timeout;
using udp::test::encoded_body;
using udp::test::fields;
using udp::test::Image;
using udp::test::make_image;

/// Two nodes on one medium.
struct Stage {
  explicit Stage(std::unique_ptr<Medium> chosen) : medium(std::move(chosen)) {}

  const std::unique_ptr<Medium> medium;
  AnyTransport there;  ///< the transport of the writers
  AnyTransport here;   ///< the transport of the readers
  const std::unique_ptr<core::DoorbellPage> bells = core::DoorbellPage::create();
  std::atomic<std::uint32_t> readers{0};  ///< the number of readers so far
};

struct ReaderOptions {
  /// The selections that the reader accepts. It requests the first of them.
  std::vector<std::string> masks{"*"};
  std::uint32_t depth = 250;
  /// True if the reader is best-effort even if the medium's readers are usually reliable.
  bool best_effort = false;
  const TypeSupport* type = &udp::test::type_support<Image>();
};

class Writer;

class Reader final : private core::ArrivalListener {
 public:
  explicit Reader(Stage& stage, const ReaderOptions& options = {});

  /// Connects the reader to the writer, and waits until the reader is connected.
  void hear(const Writer& writer);
  core::Source source(const Writer& writer) const;
  /// Returns the route by which a writer serves this reader.
  core::Route route() const { return route_; }
  core::Route route(const std::string& mask) const;
  core::Route route(const Selection& asked) const;
  /// Makes the reader take samples under these selections from now on. Only for networks.
  void accept(std::vector<core::Accepted> accepted);

  core::SampleHandle take();
  /// Waits for the next sample and returns it. Returns an empty handle after `hang_timeout`.
  core::SampleHandle next();
  /// Waits for that number of samples, and returns their sequences. Returns fewer if samples do not arrive.
  std::vector<std::uint64_t> next_sequences(std::size_t count);
  /// Takes all samples that have arrived, and returns their sequences.
  std::vector<std::uint64_t> take_sequences();

  core::ReaderPort& port() { return *port_; }
  std::uint64_t discarded() const { return port_->counters().discarded; }
  std::uint64_t lost_unnoticed() const { return port_->counters().lost_unnoticed; }
  /// Returns the number of times that this reader's doorbell was rung.
  std::uint32_t rings() const { return bell_.rings; }
  void destroy_port() { port_.reset(); }

 private:
  void arrived() noexcept override { bell_.ring(); }

  core::Doorbell& bell_;
  const TypeSupport& type_;
  const bool reliable_;
  core::Route route_;
  AnyReader port_;  // destroyed first; after that the port does not call arrived()
};

/// A writer of images. Sample number n is an image made from the seed n, unless make_of() gets another
/// message.
class Writer {
 public:
  /// `max_blocking` is the time that the writer may wait for reliable readers.
  explicit Writer(Stage& stage, core::EndpointId id = 1, std::chrono::nanoseconds max_blocking = {},
                  const TypeSupport& type = udp::test::type_support<Image>());

  core::EndpointId id() const { return id_; }
  std::uint64_t sequence() const { return sequence_; }
  bool waits() const { return waits_; }
  void serve(std::vector<core::Route> routes) { port_->set_routes(std::move(routes)); }
  /// Connects the reader to this writer, and makes the writer serve this reader alone.
  void serve(Reader& reader);

  /// Makes the next sample without sending it. Returns an empty handle if there is no memory for the sample
  /// and for `bytes_behind` bytes after its body.
  core::SampleHandle make(std::size_t data_bytes, std::size_t bytes_behind = 0);
  /// Makes the next sample from a message of the writer's type.
  template <class Message>
  core::SampleHandle make_of(const Message& message, std::size_t bytes_behind = 0) {
    const FieldMask all = udp::test::type_support<Message>().full();
    core::SampleHandle sample = memory_for(udp::test::sample_bytes(message, all) + bytes_behind);
    if (sample) udp::test::fill(*sample, message, all, id_, ++sequence_);
    return sample;
  }
  core::SendStatus publish(std::size_t data_bytes = 50);
  /// Publishes a sample, and waits until it has arrived at the reader.
  void publish_to(Reader& reader, std::size_t data_bytes = 50);

  core::WriterPort& port() { return *port_; }
  /// Return the port as a port of shared memory, or as a port of a network. REQUIRES: the medium is of that
  /// kind.
  core::LendingWriter& lending_port() { return *port_.memory(); }
  core::NetworkWriter& network_port() { return *port_.network(); }
  /// Returns the bytes that were sent over the network; 0 for shared memory.
  std::uint64_t bytes_sent() const {
    return port_.network() == nullptr ? 0 : port_.network()->counters().bytes_sent;
  }
  void destroy_port() { port_.reset(); }

 private:
  core::SampleHandle memory_for(std::size_t bytes);

  core::EndpointId id_;
  const bool waits_;
  AnyWriter port_;
  std::shared_ptr<core::BufferPool> pool_ = core::BufferPool::make(std::size_t{256} << 20);
  std::uint64_t sequence_ = 0;
};

/// Publishes without pause, on a thread of its own.
class Flood {
 public:
  Flood(Stage& stage, std::vector<core::Route> routes, std::size_t data_bytes, core::EndpointId id = 1);
  const Writer& writer() const { return writer_; }
  void serve(std::vector<core::Route> routes) { writer_.serve(std::move(routes)); }

 private:
  Writer writer_;
  std::jthread thread_;
};

inline std::uint64_t sequence_of(const core::SampleHandle& sample) { return sample->sequence; }
std::vector<std::uint64_t> numbers(std::uint64_t first, std::uint64_t last);

/// Returns the closed selection that `text` names (selection.md).
Selection selection(const std::string& text, const TypeSupport& type = udp::test::type_support<Image>());
/// Succeeds if the sample has exactly the fields of the writer's image that the sample's mask names.
testing::AssertionResult is_image(const core::SampleHandle& sample, std::size_t data_bytes);
/// Succeeds if the sample is exactly the part of the writer's image that the selection takes.
testing::AssertionResult is_part(const core::SampleHandle& sample, std::size_t data_bytes,
                                 const Selection& wanted);

class Conformance : public testing::TestWithParam<MediumChoice> {
 protected:
  void SetUp() override;
  Traits traits() const { return stage.medium->traits(); }

  const testing::ScopedTrace repeat{__FILE__, __LINE__,
                                    test::how_to_repeat()};  ///< names the seed of the medium's random faults
  Stage stage{GetParam().make()};
};

/// Tests for media whose readers request reliable delivery.
class BackPressure : public Conformance {};

/// Tests for transports that can send a sample to one reader only.
class LateReaders : public Conformance {};

/// Tests for transports that send each reader only the fields that it requested.
class Projection : public Conformance {};

/// Tests for networks.
class Transmissions : public Conformance {};

}  // namespace sft::conformance
