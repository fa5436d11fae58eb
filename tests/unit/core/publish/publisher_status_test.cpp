// What a publisher's status says of samples that did not reach everybody.
#include <gtest/gtest.h>

#include <sensor_msgs/msg/PointCloud2.hpp>

#include "core/publish/publisher_core.h"

namespace sft::core {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;

class CountingPort final : public WriterPort {
 public:
  SendStatus send(const SampleHandle&) noexcept override { return answer; }
  void set_routes(std::vector<Route>) override {}
  std::uint64_t bytes_sent() const noexcept override { return 0; }
  std::uint64_t dropped() const noexcept override { return dropped_later; }

  SendStatus answer = SendStatus::sent;
  std::uint64_t dropped_later = 0;
};

TEST(PublisherStatusTest, CountsWhatWasRefusedAndWhatWasDroppedAfterItWasTaken) {
  const TypeSupport type{TypeTable<PointCloud2>::type};
  const auto udp = std::make_shared<CountingPort>();
  PublisherCore::Spec spec;
  spec.type = &type;
  spec.max_sample_bytes = 1000;
  PublisherCore publisher(spec, BufferPool::make(1 << 20), udp);
  Serving serving;
  serving.udp = {{2, UdpAddress{0x7f000001, 5000}, type.full()}};
  publisher.serve(serving, nullptr);
  const PointCloud2 cloud;
  EXPECT_EQ(publisher.publish(&cloud), PublishStatus::ok);
  EXPECT_EQ(publisher.status().dropped, 0U);
  udp->dropped_later = 2;
  EXPECT_EQ(publisher.status().dropped, 2U);
  udp->answer = SendStatus::dropped;
  EXPECT_EQ(publisher.publish(&cloud), PublishStatus::dropped);
  EXPECT_EQ(publisher.status().dropped, 3U);
}

}  // namespace
}  // namespace sft::core
