// How a publisher changes over from one division of its readers to another.
#include <gtest/gtest.h>

#include <cstring>
#include <future>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "core/publisher_core.h"
#include "sft/typesupport/encode.h"
#include "sft/typesupport/project.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

/// Sends as long as it is made to.
class SlowPort final : public WriterPort {
 public:
  SendStatus send(const SampleHandle&) noexcept override {
    sending.set_value();
    go_on.get_future().wait();
    return SendStatus::sent;
  }
  void set_routes(std::vector<Route>) override { ++routes_set; }
  std::uint64_t bytes_sent() const noexcept override { return 0; }

  std::promise<void> sending;
  std::promise<void> go_on;
  std::atomic<int> routes_set{0};
};

class PublisherServingTest : public ::testing::Test {
 protected:
  Serving to_one(const FieldMask& mask) const {
    Serving serving;
    serving.udp = {{2, UdpAddress{0x7f000001, 5000}, type.closed(mask)}};
    return serving;
  }

  std::vector<std::byte> payload() const {
    const FieldMask all = type.full();
    std::vector<std::byte> bytes(encapsulation_bytes + encoded_size(type.type(), &cloud, all).bytes);
    std::memcpy(bytes.data(), encapsulation_cdr_le.data(), encapsulation_bytes);
    std::vector<std::uint32_t> index(type.slots());
    encode(type.type(), &cloud, all, std::span(bytes).subspan(encapsulation_bytes), index);
    return bytes;
  }

  /// `publish` is held in the port while a reader asks for more than before.
  template <class Publish>
  void expect_waited_for(Publish publish) {
    publisher.serve(to_one(FieldMask(F::height)), nullptr);
    auto publishing = std::async(std::launch::async, publish);
    port->sending.get_future().wait();
    auto serving = std::async(std::launch::async, [&] { publisher.serve(to_one(type.full()), nullptr); });
    EXPECT_EQ(serving.wait_for(50ms), std::future_status::timeout);
    EXPECT_EQ(port->routes_set, 1);
    port->go_on.set_value();
    serving.wait();
    publishing.wait();
    EXPECT_EQ(port->routes_set, 2);
  }

  const TypeSupport type{TypeTable<PointCloud2>::type};
  const PointCloud2 cloud{};
  const std::shared_ptr<SlowPort> port = std::make_shared<SlowPort>();
  PublisherCore publisher{{1, "points", &type, 1 << 16}, BufferPool::make(1 << 20), port};
};

TEST_F(PublisherServingTest, RoutesThatAskForMoreWaitForAPublishThatBeganBefore) {
  expect_waited_for([&] { publisher.publish(&cloud); });
}

TEST_F(PublisherServingTest, RoutesThatAskForMoreWaitForALoanBeingPublished) {
  expect_waited_for([&] {
    Result<SampleHandle> loan = publisher.loan(&cloud, {}, ReservedMemory::zeroed);
    ASSERT_TRUE(loan);
    publisher.commit(std::move(*loan), false);
  });
}

TEST_F(PublisherServingTest, RoutesThatAskForMoreWaitForAPayloadBeingPublished) {
  expect_waited_for([&] { EXPECT_TRUE(publisher.publish_cdr(payload())); });
}

TEST_F(PublisherServingTest, APayloadIsWalkedOnlyIfSomebodyReads) {
  std::vector<std::byte> cut = payload();
  cut.resize(cut.size() / 2);
  EXPECT_EQ(publisher.publish_cdr(cut).value(), PublishStatus::ok);
  EXPECT_EQ(publisher.status().published, 1U);
  publisher.serve(to_one(type.full()), nullptr);
  EXPECT_EQ(publisher.publish_cdr(cut).error().code, Errc::malformed);
  EXPECT_EQ(publisher.status().published, 1U);
}

TEST_F(PublisherServingTest, OfAPayloadThatNobodyReadsTheEncapsulationIsCheckedAllTheSame) {
  EXPECT_FALSE(publisher.publish_cdr({}));
}

TEST_F(PublisherServingTest, OnceClosedItTellsTheProgramOfNoReaders) {
  int told = 0;
  PublisherCore::Spec spec{1, "points", &type, 1 << 16};
  spec.on_readers_changed = [&](const PublisherStatus&) { ++told; };
  PublisherCore telling(spec, BufferPool::make(1 << 20), port);
  telling.serve(to_one(type.full()), nullptr);
  EXPECT_EQ(told, 1);
  telling.close();
  telling.serve({}, nullptr);
  EXPECT_EQ(told, 1);
}

}  // namespace
}  // namespace sft::core
