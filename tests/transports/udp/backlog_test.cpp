// A process that does not read for a long time causes no loss in other processes. Only the process itself
// loses samples.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <vector>

#include "core/negotiation/accepted_requests.h"
#include "tests/transports/udp/backends.h"
#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/faulty_io.h"
#include "tests/transports/udp/transport_fixture.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using test::encoded_body;
using test::fields;
using test::Image;
using test::loopback_address;
using test::make_image;
using test::Publisher;
using test::Subscriber;

class BacklogTest : public TransportTest {
 protected:
  /// Opens a transport whose connection to the gate's address is full until the gate is opened.
  std::unique_ptr<core::Network> open_before(test::Gate& gate, std::shared_ptr<core::BufferPool> pool) {
    UdpOptions options;
    options.bind_address = INADDR_LOOPBACK;
    options.backend = GetParam();
    return open_udp_transport(options, std::move(pool),
                              [&](DatagramIo io) { return gate.put_around(std::move(io)); })
        .value();
  }
};

INSTANTIATE_TEST_SUITE_P(Backends, BacklogTest, test::both_backends, test::backend_name);

TEST_P(BacklogTest, NothingIsLostThatWaitsLongAfterItsReaderAskedForSomethingElse) {
  const auto here = open();
  test::Gate gate(loopback_address(*here).port);
  const auto there = open_before(gate, test::make_pool());
  Subscriber subscriber(*here, {});
  Publisher publisher(*there);
  core::AcceptedRequests requests({fields<Image>("*")}, true);
  subscriber.port().accept(requests.all());
  subscriber.listen_reliably_to(publisher.id());
  publisher.serve({{loopback_address(*here), "*", true}});
  for (int i = 0; i < 100; ++i) publisher.publish(make_image(i % 10 == 0 ? 100'000 : 50));
  const auto now = std::chrono::steady_clock::now();
  requests.asks_for({fields<Image>("data")}, now);
  requests.look(now + 1h);
  subscriber.port().accept(requests.all());
  publisher.serve({{loopback_address(*here), "data", true}});
  for (int i = 0; i < 50; ++i) publisher.publish(make_image(50));
  gate.open();
  const std::vector<core::SampleHandle> got = subscriber.await(150);
  EXPECT_EQ(subscriber.await_sequences(150), first_numbers(150));
  ASSERT_EQ(got.size(), 150U);
  EXPECT_EQ(got[99]->mask, fields<Image>("*"));
  EXPECT_EQ(got[100]->mask, fields<Image>("data"));
}

TEST_P(BacklogTest, ManyPublishersToAProcessThatDoesNotReadLeaveMemoryToOthers) {
  const auto silent = open(), here = open();
  test::Gate gate(loopback_address(*silent).port);
  const auto memory = core::BufferPool::make(std::size_t{32} << 20);
  const auto there = open_before(gate, memory);
  std::vector<std::unique_ptr<Publisher>> publishers;
  for (core::EndpointId id = 1; id <= 5; ++id) {
    publishers.push_back(std::make_unique<Publisher>(*there, id));
    publishers.back()->serve({{loopback_address(*silent), "*", true}});
  }
  for (int i = 0; i < 20; ++i) {
    for (const auto& publisher : publishers) {
      const core::SampleHandle sample = publisher->make(make_image(1'000'000), *memory);
      ASSERT_TRUE(sample) << "of publisher " << publisher->id() << ", " << i;
      publisher->port().send(sample);
    }
  }
  EXPECT_GT(there->counters().over_limit, 0U) << "what had to go is counted";
  Subscriber subscriber(*here, {"*"});
  Publisher other(*there, 6);
  subscriber.listen_reliably_to(other.id());
  other.serve({{loopback_address(*here), "*", true}});
  for (int i = 0; i < 100; ++i) {
    const core::SampleHandle sample = other.make(make_image(100'000), *memory);
    ASSERT_TRUE(sample) << i;
    EXPECT_EQ(other.port().send(sample), core::SendStatus::sent);
    if (i % 4 == 3) {
      ASSERT_EQ(subscriber.await(i + 1U).size(), i + 1U);
    }
  }
}

TEST_P(BacklogTest, WhatLiesInBorrowedMemoryIsCopiedForAProcessThatDoesNotRead) {
  const auto here = open();
  test::Gate gate(loopback_address(*here).port);
  const auto there = open_before(gate, test::make_pool());
  const auto borrowed = core::BufferPool::make(std::size_t{12} << 20);
  Subscriber subscriber(*here, {"*"});
  Publisher publisher(*there);
  subscriber.listen_reliably_to(publisher.id());
  publisher.serve({{loopback_address(*here), "*", true}});
  constexpr std::uint32_t samples = 40;
  for (std::uint32_t i = 0; i < samples; ++i) {
    const core::SampleHandle sample = publisher.make(make_image(1'000'000, i), *borrowed);
    ASSERT_TRUE(sample) << i;
    EXPECT_EQ(publisher.port().send(sample), core::SendStatus::sent);
  }
  gate.open();
  const std::vector<core::SampleHandle> got = subscriber.await(samples);
  ASSERT_EQ(got.size(), samples);
  for (std::uint32_t i = 0; i < samples; ++i)
    EXPECT_EQ(test::body_of(*got[i]), encoded_body(make_image(1'000'000, i), fields<Image>("*"))) << i;
}

}  // namespace
}  // namespace sft::udp
