// The words that the conformance suite is written in: a writer on one node and readers on another, which
// sleep until their transport wakes them. Nothing here polls for samples, so a lost wake-up is a failed test.
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
  AnyTransport there;  ///< of the writers
  AnyTransport here;   ///< of the readers
  const std::unique_ptr<core::DoorbellPage> bells = core::DoorbellPage::create();
  std::atomic<std::uint32_t> readers{0};  ///< the number of readers so far
};

struct ReaderOptions {
  std::vector<std::string> masks{"*"};  ///< selections that it accepts; it asks for the first
  std::uint32_t depth = 250;
  bool best_effort = false;  ///< whatever the medium's readers ask for
  const TypeSupport* type = &udp::test::type_support<Image>();
};

class Writer;

class Reader final : private core::ArrivalListener {
 public:
  explicit Reader(Stage& stage, const ReaderOptions& options = {});

  /// Waits until it is connected.
  void hear(const Writer& writer);
  core::Source source(const Writer& writer) const;
  /// The route that the writer needs to serve this reader.
  core::Route route() const { return route_; }
  core::Route route(const std::string& mask) const;
  core::Route route(const Selection& asked) const;
  /// Over a network: it takes samples under these selections from now on.
  void accept(std::vector<core::Accepted> accepted);

  core::SampleHandle take();
  /// The next sample, as soon as it has come; empty after `hang_timeout`.
  core::SampleHandle next();
  /// Waits for so many samples, and returns their sequences; fewer if they do not come.
  std::vector<std::uint64_t> next_sequences(std::size_t count);
  /// Returns the sequences of the samples that are there.
  std::vector<std::uint64_t> take_sequences();

  core::ReaderPort& port() { return *port_; }
  std::uint64_t discarded() const { return port_->counters().discarded; }
  std::uint64_t lost_unnoticed() const { return port_->counters().lost_unnoticed; }
  /// The number of times that its doorbell was rung so far.
  std::uint32_t rings() const { return bell_.rings; }
  void destroy_port() { port_.reset(); }

 private:
  void arrived() noexcept override { bell_.ring(); }

  core::Doorbell& bell_;
  const TypeSupport& type_;
  const bool reliable_;
  core::Route route_;
  AnyReader port_;  // goes first: then nobody calls any more
};

/// A writer whose sample number n is an image made of the seed n, unless it is given messages of another
/// type.
class Writer {
 public:
  /// Waits for reliable readers for so long.
  explicit Writer(Stage& stage, core::EndpointId id = 1, std::chrono::nanoseconds max_blocking = {},
                  const TypeSupport& type = udp::test::type_support<Image>());

  core::EndpointId id() const { return id_; }
  std::uint64_t sequence() const { return sequence_; }
  bool waits() const { return waits_; }
  void serve(std::vector<core::Route> routes) { port_->set_routes(std::move(routes)); }
  /// Makes it hear and be served, alone.
  void serve(Reader& reader);

  /// The next sample, not sent; empty where there is no memory for it, or for so many bytes behind its body.
  core::SampleHandle make(std::size_t data_bytes, std::size_t bytes_behind = 0);
  /// The same with a message of the writer's type.
  template <class Message>
  core::SampleHandle make_of(const Message& message, std::size_t bytes_behind = 0) {
    const FieldMask all = udp::test::type_support<Message>().full();
    core::SampleHandle sample = memory_for(udp::test::sample_bytes(message, all) + bytes_behind);
    if (sample) udp::test::fill(*sample, message, all, id_, ++sequence_);
    return sample;
  }
  core::SendStatus publish(std::size_t data_bytes = 50);
  /// Waits until the reader has noticed it.
  void publish_to(Reader& reader, std::size_t data_bytes = 50);

  core::WriterPort& port() { return *port_; }
  /// The port as the kind that such a medium has.
  core::LendingWriter& lending_port() { return *port_.memory(); }
  core::NetworkWriter& network_port() { return *port_.network(); }
  /// Over a network.
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

/// True if the sample has what its writer put there, of the fields that its mask names, and nothing else.
/// Of images, as text (selection.md); closed.
Selection selection(const std::string& text, const TypeSupport& type = udp::test::type_support<Image>());
testing::AssertionResult is_image(const core::SampleHandle& sample, std::size_t data_bytes);
/// True if the sample has just what that selection says of what its writer put there.
testing::AssertionResult is_part(const core::SampleHandle& sample, std::size_t data_bytes,
                                 const Selection& wanted);

class Conformance : public testing::TestWithParam<MediumChoice> {
 protected:
  void SetUp() override;
  Traits traits() const { return stage.medium->traits(); }

  const testing::ScopedTrace repeat{__FILE__, __LINE__,
                                    test::how_to_repeat()};  ///< of what a medium makes random
  Stage stage{GetParam().make()};
};

/// Runs on media whose readers ask for reliability.
class BackPressure : public Conformance {};

/// Runs on transports that can send one reader something apart from all others.
class LateReaders : public Conformance {};

/// Runs on transports that send each reader only its fields.
class Projection : public Conformance {};

/// Runs on networks.
class Transmissions : public Conformance {};

}  // namespace sft::conformance
