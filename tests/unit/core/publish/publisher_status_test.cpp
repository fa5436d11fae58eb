// Tests the status of a publisher after samples did not reach all readers.
#include <gtest/gtest.h>

#include <algorithm>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <vector>

#include "core/publish/publisher_core.h"
#include "tests/unit/core/publish/port_logs.h"
#include "tests/unit/core/seam/idle_ports.h"

namespace sft::core {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;

class CountingPort final : public IdleNetworkWriter {
 public:
  Counters counters() const noexcept override { return {.dropped = dropped_later}; }

  SendStatus answer = SendStatus::sent;
  std::uint64_t dropped_later = 0;
  std::size_t missed = 0;  ///< the number of samples of a batch that the port drops
  int sent = 0;

 private:
  std::size_t flush() noexcept override { return missed; }
  SendStatus send_begun(const SampleHandle&, Reach) noexcept override {
    ++sent;
    return answer;
  }
};

/// A publisher with a port to the network.
class PublisherStatusTest : public testing::Test {
 protected:
  /// Serves one reader, with a maximum rate if `min_period_us` is not 0.
  void serve(std::uint32_t min_period_us = 0) {
    Serving serving;
    serving.network = {{2, UdpAddress{0x7f000001, 5000}, type.full()}};
    serving.network[0].min_period_us = min_period_us;
    publisher.serve(serving, nullptr);
  }

  static PublisherCore::Spec spec_of(const TypeSupport& published) {
    PublisherCore::Spec spec;
    spec.type = &published;
    spec.max_sample_bytes = 1000;
    return spec;
  }

  const TypeSupport type{TypeTable<PointCloud2>::type};
  const std::shared_ptr<CountingPort> network = std::make_shared<CountingPort>();
  PublisherCore publisher{spec_of(type), BufferPool::make(1 << 20), network};
};

TEST_F(PublisherStatusTest, CountsWhatWasRefusedAndWhatWasDroppedAfterItWasTaken) {
  serve();
  const PointCloud2 cloud;
  EXPECT_EQ(publisher.publish(&cloud), PublishStatus::ok);
  EXPECT_EQ(publisher.status().dropped, 0U);
  network->dropped_later = 2;
  EXPECT_EQ(publisher.status().dropped, 2U);
  network->answer = SendStatus::dropped;
  EXPECT_EQ(publisher.publish(&cloud), PublishStatus::dropped);
  EXPECT_EQ(publisher.status().dropped, 3U);
}

/// A reader with a maximum rate gets the first sample of each slot. A refused message must not use up the
/// slot.
TEST_F(PublisherStatusTest, AMessageThatIsRefusedIsNotPublishedAndTakesNoSlotOfAReaderWithARate) {
  constexpr std::uint32_t an_hour_us = 3'600'000'000;  // so long that no slot begins during the test
  serve(an_hour_us);
  PointCloud2 not_text, too_large;
  not_text.header.frame_id = std::string("a\0b", 3);
  too_large.data.resize(2000);
  for (const PointCloud2* refused : {&not_text, &too_large})
    EXPECT_EQ(publisher.publish(refused), PublishStatus::invalid);
  EXPECT_EQ(publisher.status().published, 0U);
  EXPECT_EQ(publisher.status().dropped, 0U);
  const PointCloud2 cloud;
  for (const int sent : {1, 1}) {
    EXPECT_EQ(publisher.publish(&cloud), PublishStatus::ok);
    EXPECT_EQ(network->sent, sent);
  }
  EXPECT_EQ(publisher.status().published, 2U);
}

TEST_F(PublisherStatusTest, SamplesPublishedTogetherThatDoNotLeaveAreDroppedAndTheOthersArePublished) {
  serve();
  const std::vector<PointCloud2> clouds(5);
  std::uint64_t published = 0, dropped = 0;
  for (const std::size_t missed : {0, 2, 9}) {
    network->missed = missed;
    const PublishedSpan done = publisher.publish(clouds.data(), clouds.size(), sizeof(PointCloud2));
    const std::size_t lost = std::min(missed, clouds.size());
    EXPECT_EQ(done.published, clouds.size() - lost);
    EXPECT_EQ(done.status, lost == 0 ? PublishStatus::ok : PublishStatus::dropped);
    EXPECT_EQ(publisher.status().published, published += clouds.size());
    EXPECT_EQ(publisher.status().dropped, dropped += lost);
  }
}

TEST_F(PublisherStatusTest, WhatAReaderMissedIsAmongWhatWasPublishedForIt) {
  const auto memory = std::make_shared<test::MemoryLog>();
  Serving serving;
  serving.memory = {test::memory_route(1, type)};
  serving.readers = {{.id = 1, .node = "n", .served = true}};
  publisher.serve(serving, memory);
  const PointCloud2 cloud;
  EXPECT_EQ(publisher.publish(&cloud), PublishStatus::ok);
  memory->is_full = true;
  EXPECT_EQ(publisher.publish(&cloud), PublishStatus::no_memory);
  const PublisherStatus::Reader reader = publisher.status().readers.at(0);
  EXPECT_EQ(reader.published, 2U);
  EXPECT_EQ(reader.sent, 1U);
  EXPECT_EQ(reader.dropped, 1U);
}

TEST_F(PublisherStatusTest, WhetherItKeepsItsPromisesIsNewsOnlyIfSomethingDiffers) {
  EXPECT_FALSE(publisher.keeps_promises(0, true));
  EXPECT_TRUE(publisher.keeps_promises(1, true));
  EXPECT_FALSE(publisher.keeps_promises(1, true));
  EXPECT_TRUE(publisher.keeps_promises(1, false));
  EXPECT_FALSE(publisher.keeps_promises(1, false));
  EXPECT_EQ(publisher.status().deadlines_missed, 1U);
  EXPECT_FALSE(publisher.status().alive);
}

/// More than 1,024 messages are sent in several calls.
TEST_F(PublisherStatusTest, TheStatusOfALongSpanIsThatOfTheFirstMessageThatIsNotPublished) {
  serve();
  std::vector<PointCloud2> clouds(2000);
  clouds[3].header.frame_id = std::string("a\0b", 3);
  const auto publish = [&] { return publisher.publish(clouds.data(), clouds.size(), sizeof(PointCloud2)); };
  PublishedSpan done = publish();
  EXPECT_EQ(done.status, PublishStatus::invalid);
  EXPECT_EQ(done.published, 1999U);
  network->answer = SendStatus::dropped;
  done = publish();
  EXPECT_EQ(done.status, PublishStatus::dropped);
  EXPECT_EQ(done.published, 0U);
}

/// Other nodes compare the progress with the samples that arrive. So samples that cannot arrive must not be
/// counted.
TEST_F(PublisherStatusTest, TheProgressCountsNeitherWhatWasDroppedNorWhatLateReadersMissed) {
  const auto memory = std::make_shared<test::MemoryLog>();
  PublisherCore::Spec spec = spec_of(type);
  spec.qos.durability = Durability::transient_local;
  spec.qos.history_depth = 5;
  PublisherCore durable(std::move(spec), BufferPool::make(1 << 20), network);
  const PointCloud2 cloud;
  for (int i = 0; i < 5; ++i) EXPECT_EQ(durable.publish(&cloud), PublishStatus::ok);
  EXPECT_EQ(durable.progress().samples, 5U);
  Serving serving;
  serving.memory = {test::memory_route(1, type)};
  serving.memory[0].history = 2;
  memory->is_full = true;
  durable.serve(serving, memory);
  EXPECT_EQ(durable.progress().samples, 3U);
  EXPECT_EQ(durable.status().dropped, 2U);
  EXPECT_EQ(durable.publish(&cloud), PublishStatus::no_memory);
  EXPECT_EQ(durable.progress().samples, 3U);
}

}  // namespace
}  // namespace sft::core
