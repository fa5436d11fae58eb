// Tests what a publisher's status says of samples that did not reach everybody.
#include <gtest/gtest.h>

#include <sensor_msgs/msg/PointCloud2.hpp>

#include "core/publish/publisher_core.h"
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

 private:
  SendStatus send_begun(const SampleHandle&, Reach) noexcept override { return answer; }
};

TEST(PublisherStatusTest, CountsWhatWasRefusedAndWhatWasDroppedAfterItWasTaken) {
  const TypeSupport type{TypeTable<PointCloud2>::type};
  const auto network = std::make_shared<CountingPort>();
  PublisherCore::Spec spec;
  spec.type = &type;
  spec.max_sample_bytes = 1000;
  PublisherCore publisher(spec, BufferPool::make(1 << 20), network);
  Serving serving;
  serving.network = {{2, UdpAddress{0x7f000001, 5000}, type.full()}};
  publisher.serve(serving, nullptr);
  const PointCloud2 cloud;
  EXPECT_EQ(publisher.publish(&cloud), PublishStatus::ok);
  EXPECT_EQ(publisher.status().dropped, 0U);
  network->dropped_later = 2;
  EXPECT_EQ(publisher.status().dropped, 2U);
  network->answer = SendStatus::dropped;
  EXPECT_EQ(publisher.publish(&cloud), PublishStatus::dropped);
  EXPECT_EQ(publisher.status().dropped, 3U);
}

}  // namespace
}  // namespace sft::core
