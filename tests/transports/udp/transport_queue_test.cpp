// Samples that cannot be sent at once, or that no reader takes yet.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/faulty_io.h"
#include "tests/transports/udp/transport_fixture.h"

namespace sft::udp {
namespace {

using test::encoded_body;
using test::eventually;
using test::fields;
using test::Image;
using test::loopback_address;
using test::make_image;
using test::Publisher;
using test::Subscriber;

TEST_P(TransportTest, QueuesSamplesWhileTheSendBufferIsFull) {
  const auto here = open();
  const auto there = open({.send_queue_depth = 100}, test::with_connections<test::BusyConnection>);
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  for (int i = 0; i < 50; ++i) ASSERT_EQ(publisher.publish(make_image(50)), core::SendStatus::sent);
  EXPECT_EQ(subscriber.await_sequences(50), first_numbers(50));
  publisher.publish(make_image(1'000'000));  // a large sample, which is sent in several calls
  ASSERT_EQ(subscriber.await(51).size(), 51U);
  EXPECT_EQ(test::body_of(*subscriber.await(51)[50]),
            encoded_body(make_image(1'000'000), fields<Image>("*")));
}

TEST_P(TransportTest, DropsTheOldestOfAFullQueueAndSaysSo) {
  const auto here = open();
  test::Gate gate(loopback_address(*here).port);
  const auto there =
      open({.send_queue_depth = 2}, [&](DatagramIo io) { return gate.put_around(std::move(io)); });
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  gate.open();
  publisher.publish(make_image(100'000));  // a large sample is sent only after its receiver has reported
  ASSERT_EQ(subscriber.await_sequences(1), first_numbers(1));
  gate.close();
  EXPECT_EQ(publisher.publish(make_image(100'000)), core::SendStatus::sent);
  ASSERT_TRUE(eventually([&] { return gate.has_waiting(); }));
  EXPECT_EQ(publisher.publish(make_image(100'000)), core::SendStatus::sent);
  EXPECT_EQ(publisher.publish(make_image(100'000)), core::SendStatus::sent);
  EXPECT_EQ(publisher.publish(make_image(100'000)), core::SendStatus::dropped);
  EXPECT_EQ(there->counters().over_limit, 1U);
  gate.open();
  EXPECT_EQ(subscriber.await_sequences(4), (std::vector<std::uint64_t>{1, 2, 4, 5}));
}

TEST_P(TransportTest, LetsOneDestinationFallBehindAlone) {
  const auto slow = open(), fast = open();
  test::Gate gate(loopback_address(*slow).port);
  const auto there = open({}, [&](DatagramIo io) { return gate.put_around(std::move(io)); });
  Subscriber slow_one(*slow, {"*"}), fast_one(*fast, {"*"});
  Publisher publisher(*there);
  slow_one.listen_to(publisher.id());
  fast_one.listen_to(publisher.id());
  publisher.serve({{loopback_address(*slow)}, {loopback_address(*fast)}});
  gate.open();
  publisher.publish(make_image(100'000));  // a large sample is sent only after its receiver has reported
  ASSERT_EQ(slow_one.await_sequences(1), first_numbers(1));
  gate.close();
  for (std::size_t n = 2; n <= 21; ++n) {
    publisher.publish(make_image(n % 2 != 0 ? 50 : 100'000));
    ASSERT_EQ(fast_one.await(n, std::chrono::seconds(2)).size(), n);
    if (n == 2) {
      ASSERT_TRUE(eventually([&] { return gate.has_waiting(); }));
    }
  }
  EXPECT_EQ(fast_one.await_sequences(21), first_numbers(21));
  EXPECT_EQ(there->counters().over_limit, 15U) << "all but the one being sent and the 4 queued";
  gate.open();
  EXPECT_EQ(slow_one.await_sequences(6), (std::vector<std::uint64_t>{1, 2, 18, 19, 20, 21}));
}

TEST_P(TransportTest, CountsWhatItDropsAfterItTookIt) {
  const auto here = open();
  const auto there = open({.max_datagram_bytes = 1472},
                          test::with_connections<test::TrainRefusingConnection<SendOutcome::failed>>);
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  EXPECT_EQ(publisher.publish(make_image(100'000)), core::SendStatus::sent);
  EXPECT_TRUE(eventually([&] { return publisher.port().counters().dropped == 1; }));
}

TEST_P(TransportTest, DropsASampleThatCannotLeaveForLong) {
  const auto here = open();
  test::Gate gate(loopback_address(*here).port);
  const auto there = open({}, [&](DatagramIo io) { return gate.put_around(std::move(io)); });
  Publisher publisher(*there);
  publisher.serve({{loopback_address(*here)}});
  EXPECT_EQ(publisher.publish(make_image(10)), core::SendStatus::sent);
  EXPECT_TRUE(eventually([&] { return publisher.port().counters().dropped == 1; }));
}

TEST_P(TransportTest, LetsGoOfWhatIsQueuedForADestinationThatLeft) {
  const auto here = open();
  test::Gate gate(loopback_address(*here).port);
  const auto there = open({}, [&](DatagramIo io) { return gate.put_around(std::move(io)); });
  Publisher publisher(*there);
  publisher.serve({{loopback_address(*here)}});
  const auto pool = core::BufferPool::make(150'000);
  ASSERT_EQ(publisher.publish(make_image(100'000), *pool), core::SendStatus::sent);
  ASSERT_TRUE(eventually([&] { return gate.has_waiting(); }));
  EXPECT_FALSE(pool->take(100'000)) << "it is being sent";
  publisher.serve({});
  EXPECT_TRUE(eventually([&] { return static_cast<bool>(pool->take(100'000)); }));
  EXPECT_EQ(publisher.port().counters().dropped, 0U) << "nobody misses it";
}

TEST_P(TransportTest, SendsWhatIsQueuedAfterThePublisherWent) {
  const auto here = open();
  test::Gate gate(loopback_address(*here).port);
  const auto there = open({}, [&](DatagramIo io) { return gate.put_around(std::move(io)); });
  Subscriber subscriber(*here, {"*"});
  {
    Publisher publisher(*there);
    subscriber.listen_to(publisher.id());
    publisher.serve({{loopback_address(*here)}});
    for (int i = 0; i < 3; ++i) publisher.publish(make_image(100'000));
  }
  gate.open();
  EXPECT_EQ(subscriber.await_sequences(3), first_numbers(3));
}

TEST_P(TransportTest, SendsNoMoreThanASmallReceiveBufferCanHold) {
  const auto there = open({.send_queue_depth = 20}), here = open({.receive_buffer_bytes = 212'992});
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  for (int i = 0; i < 10; ++i) EXPECT_EQ(publisher.publish(make_image(4'000'000)), core::SendStatus::sent);
  EXPECT_EQ(subscriber.await_sequences(10), first_numbers(10)) << "best effort, and nothing got lost";
}

TEST_P(TransportTest, KeepsTheRatesOfAWriterAndOfAllTogether) {
  const auto here = open();
  const auto there = open({.max_bytes_per_s = 40'000'000, .send_queue_depth = 20});
  Subscriber subscriber(*here, {"*"});
  Publisher limited(*there, 1, 10'000'000), other(*there, 2);
  for (Publisher* publisher : {&limited, &other}) {
    subscriber.listen_to(publisher->id());
    publisher->serve({{loopback_address(*here)}});
  }
  const auto begin = std::chrono::steady_clock::now();
  const auto since = [&] { return std::chrono::steady_clock::now() - begin; };
  for (int i = 0; i < 4; ++i) other.publish(make_image(1'000'000));
  limited.publish(make_image(1'500'000));
  EXPECT_TRUE(eventually([&] { return other.port().counters().bytes_sent > 4'000'000; }));
  EXPECT_GT(since(), std::chrono::milliseconds(80));
  EXPECT_TRUE(eventually([&] { return limited.port().counters().bytes_sent > 1'500'000; }));
  EXPECT_GT(since(), std::chrono::milliseconds(130));
  EXPECT_EQ(subscriber.await(5).size(), 5U);
}

TEST_P(TransportTest, LetsSmallSamplesPassLargeOnesThatHaveToWait) {
  const auto there = open({.max_bytes_per_s = 10'000'000}), here = open();
  Subscriber subscriber(*here, {"*"});
  Publisher large(*there, 1), small(*there, 2);
  for (Publisher* publisher : {&large, &small}) {
    subscriber.listen_to(publisher->id());
    publisher->serve({{loopback_address(*here)}});
  }
  large.publish(make_image(3'000'000));
  for (std::uint64_t i = 1; i <= 10; ++i) {
    small.publish(make_image(100));
    ASSERT_EQ(subscriber.await(i).size(), i);
    ASSERT_EQ(subscriber.await(i).back()->header().writer, 2U);
  }
  EXPECT_EQ(subscriber.await(11).back()->header().writer, 1U);
}

TEST_P(TransportTest, KeepsTheNewestUntilTheyAreTaken) {
  const auto there = open(), here = open();
  const auto reader = here->open_reader({.id = 1,
                                         .type = &test::type_support<Image>(),
                                         .depth = 3,
                                         .listener = nullptr,
                                         .doorbell = {}})
                          .value();
  Publisher publisher(*there);
  reader->accept({{.wanted = {fields<Image>("*")}}});
  ASSERT_TRUE(reader->connect({publisher.id(), 0}));
  publisher.serve({{loopback_address(*here)}});
  for (int i = 0; i < 10; ++i) publisher.publish(make_image(10));
  EXPECT_TRUE(eventually([&] { return reader->counters().discarded == 7; }));
  for (std::uint64_t sequence = 8; sequence <= 10; ++sequence)
    EXPECT_EQ(reader->take()->header().sequence, sequence);
  EXPECT_FALSE(reader->take());
}

TEST_P(TransportTest, ReceivesIntoThePoolThatItSharesWithTheNode) {
  const auto pool = core::BufferPool::make(1'000'000);
  const auto there = open();
  const auto here =
      open_udp_transport({.bind_address = GetParam().loopback, .backend = GetParam()}, pool).value();
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_to(publisher.id());
  publisher.serve({{loopback_address(*here)}});
  std::vector<core::SampleHandle> published_here;
  while (core::SampleHandle sample = pool->take(200'000)) published_here.push_back(std::move(sample));
  publisher.publish(make_image(100'000));
  EXPECT_TRUE(eventually([&] { return here->counters().over_limit == 1; }));
  published_here.clear();
  publisher.publish(make_image(100'000));
  EXPECT_EQ(subscriber.await_sequences(1), std::vector<std::uint64_t>{2});
}

}  // namespace
}  // namespace sft::udp
