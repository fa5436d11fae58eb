// Samples that are published together, between two transports.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/test_seed.h"
#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/faulty_io.h"
#include "tests/transports/udp/transport_fixture.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using test::fields;
using test::Image;
using test::loopback_address;
using test::make_image;
using test::Publisher;
using test::Subscriber;

class SpanTest : public TransportTest {
 protected:
  /// Opens a transport with datagrams of the length that Ethernet carries.
  std::unique_ptr<core::Network> open(double loss = 0) {
    return TransportTest::open({.max_datagram_bytes = 1472}, [&](DatagramIo io) {
      return test::with_faults(std::move(io), {.loss = loss}, static_cast<unsigned>(sft::test::test_seed()));
    });
  }
  static void publish(Publisher& publisher, const std::vector<std::size_t>& data_bytes) {
    core::Batch batch = publisher.port().batch(core::BatchTimeout::fresh);
    for (const std::size_t bytes : data_bytes) {
      core::SampleHandle sample = publisher.make(make_image(bytes));
      sample->source_stamp_ns = 7;  // all samples of a span have this stamp
      publisher.port().send(sample);
    }
    EXPECT_EQ(std::move(batch).flush(), 0U);
  }
};

INSTANTIATE_TEST_SUITE_P(Backends, SpanTest, test::both_backends, test::backend_name);

TEST_P(SpanTest, SharesDatagramsAndGivesEachReaderItsFields) {
  const auto there = open(), here = open(), elsewhere = open();
  Subscriber bytes(*here, {"data"}, 1000, 1), all(*elsewhere, {"*"}, 1000, 2);
  Publisher publisher(*there);
  bytes.listen_to(publisher.id());
  all.listen_reliably_to(publisher.id());
  publisher.serve({{loopback_address(*here), "data"}, {loopback_address(*elsewhere), "*", true}});
  publish(publisher, std::vector<std::size_t>(300, 40));
  EXPECT_EQ(all.await_sequences(300), first_numbers(300));
  EXPECT_EQ(bytes.await_sequences(300), first_numbers(300));
  EXPECT_EQ(test::body_of(*all.await(300)[299]), test::encoded_body(make_image(40), fields<Image>("*")));
  EXPECT_EQ(test::body_of(*bytes.await(300)[0]), test::encoded_body(make_image(40), fields<Image>("data")));
  EXPECT_LT(publisher.port().counters().bytes_sent, 300 * (44 + 79) * 11 / 10);
}

TEST_P(SpanTest, KeepsTheOrderWhereSomeSamplesAreLarge) {
  const auto there = open(), here = open();
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_reliably_to(publisher.id());
  publisher.serve({{loopback_address(*here), "*", true}});
  publish(publisher, {10, 20, 5000, 0, 30, 100'000, 300, 900, 7});
  EXPECT_EQ(subscriber.await_sequences(9), first_numbers(9));
}

TEST_P(SpanTest, KeepsTheOrderOfSamplesForAProcessThatIsSentSeveralMasks) {
  const auto there = open(), here = open();
  Subscriber both(*here, {"data", "*"}, 1000, 1), other(*here, {"*"}, 1000, 2);
  Publisher publisher(*there);
  both.listen_reliably_to(publisher.id());
  other.listen_reliably_to(publisher.id());
  publisher.serve({{loopback_address(*here), "data", true}, {loopback_address(*here), "*", true}});
  publish(publisher, std::vector<std::size_t>(100, 40));
  EXPECT_EQ(both.await_sequences(100), first_numbers(100));
  EXPECT_EQ(other.await_sequences(100), first_numbers(100));
}

TEST_P(SpanTest, LosesNothingOverABadLink) {
  SCOPED_TRACE(sft::test::how_to_repeat());
  const auto there = open(0.05), here = open(0.05);
  Subscriber subscriber(*here, {"*"}, 5000);
  Publisher publisher(*there);
  subscriber.listen_reliably_to(publisher.id());
  publisher.serve({{loopback_address(*here), "*", true}});
  for (std::size_t n = 1; n <= 10; ++n) publish(publisher, std::vector<std::size_t>(200, n * 17));
  EXPECT_EQ(subscriber.await_sequences(2000), first_numbers(2000));
}

TEST_P(SpanTest, LosesNothingToAReaderThatTakesAtOnceHoweverFewMayWait) {
  const auto there = open(), here = open();
  Subscriber subscriber(*here, {"*"}, 1);
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here), "*"}});
  publish(publisher, std::vector<std::size_t>(50, 5));
  EXPECT_EQ(subscriber.await_sequences(50), first_numbers(50));
  EXPECT_EQ(subscriber.port().counters().discarded, 0U);
}

TEST_P(SpanTest, WaitsForAReaderThatDoesNotKeepUpAsLongAsItMay) {
  const auto there = open(), here = open();
  Subscriber subscriber(*here, {"*"}, 10'000);
  const auto open_writer = [&](core::EndpointId id, std::chrono::nanoseconds max_blocking) {
    return there->open_writer({id, &test::type_support<Image>(), true, max_blocking}).value();
  };
  auto port = open_writer(7, 1s);  // a long time, because a busy machine may run the reader's thread late
  subscriber.listen_reliably_to(7);
  core::Route route{1, loopback_address(*here), fields<Image>("*")};
  route.reliable = true;
  port->set_routes({route});
  const auto pool = test::make_pool();
  const Image image = make_image(20);
  for (std::uint64_t sequence = 1; sequence <= 10'000;) {
    core::Batch batch = port->batch(core::BatchTimeout::fresh);
    for (int i = 0; i < 1000; ++i, ++sequence) {
      const core::SampleHandle sample = pool->take(test::sample_bytes(image, fields<Image>("*")));
      test::fill(*sample, image, fields<Image>("*"), 7, sequence);
      sample->source_stamp_ns = 7;
      ASSERT_EQ(port->send(sample), core::SendStatus::sent);
    }
    ASSERT_EQ(std::move(batch).flush(), 0U);
  }
  EXPECT_EQ(subscriber.await_sequences(10'000), first_numbers(10'000));

  port = open_writer(8, 50ms);
  route.destination = core::UdpAddress{0x7f000001, 9, 0};  // a port at which no process receives
  port->set_routes({route});
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 4100; ++i) {
    const core::SampleHandle sample = pool->take(test::sample_bytes(image, fields<Image>("*")));
    test::fill(*sample, image, fields<Image>("*"), 8, 1 + i);
    if (port->send(sample) == core::SendStatus::dropped) break;
  }
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 50ms);
}

/// Sends samples to processes that do not exist, until each new sample displaces the oldest one.
class FullSpanTest : public SpanTest {
 protected:
  static constexpr auto max_blocking = std::chrono::milliseconds(200);

  void open_to(const std::vector<std::uint16_t>& ports, std::uint64_t max_bytes_per_s = 0) {
    port_ = there_
                ->open_writer({.id = 7,
                               .type = &test::type_support<Image>(),
                               .max_blocking = max_blocking,
                               .max_bytes_per_s = max_bytes_per_s})
                .value();
    std::vector<core::Route> routes;
    for (const std::uint16_t port : ports) {
      routes.push_back({port, core::UdpAddress{0x7f000001, port, 0}, fields<Image>("*")});
      routes.back().reliable = true;
    }
    port_->set_routes(routes);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(send(1024, core::BatchTimeout::fresh), 0U);
  }
  /// Sends samples together. Returns the number of samples that were missed.
  std::size_t send(std::size_t samples, core::BatchTimeout hang_timeout) {
    core::Batch batch = port_->batch(hang_timeout);
    for (; samples > 0; --samples) {
      const core::SampleHandle sample = pool_->take(test::sample_bytes(image_, fields<Image>("*")));
      test::fill(*sample, image_, fields<Image>("*"), 7, ++sequence_);
      sample->source_stamp_ns = 7;
      port_->send(sample);
    }
    return std::move(batch).flush();
  }

  void SetUp() override {
    TransportTest::SetUp();
    if (!IsSkipped()) there_ = open();
  }

  std::unique_ptr<core::Network> there_;
  std::unique_ptr<core::NetworkWriter> port_;
  const std::shared_ptr<core::BufferPool> pool_ = test::make_pool();
  const Image image_ = make_image(20);
  std::uint64_t sequence_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Backends, FullSpanTest, test::both_backends, test::backend_name);

TEST_P(FullSpanTest, WaitsForItsPartsTogetherNoLongerThanForOne) {
  open_to({9});
  const auto begin = std::chrono::steady_clock::now();
  send(1024, core::BatchTimeout::fresh);
  for (int i = 0; i < 49; ++i) send(1024, core::BatchTimeout::continued);
  const auto took = std::chrono::steady_clock::now() - begin;
  EXPECT_GE(took, max_blocking);
  EXPECT_LT(took, 25 * max_blocking) << "and not once for each of fifty parts";
}

TEST_P(FullSpanTest, CountsASampleOnceThatSeveralMiss) {
  open_to({9, 10}, 1);  // a rate at which nearly no sample is sent
  for (int i = 0; i < 2; ++i) send(1024, core::BatchTimeout::fresh);
  EXPECT_EQ(send(10, core::BatchTimeout::fresh), 10U);
}

}  // namespace
}  // namespace sft::udp
