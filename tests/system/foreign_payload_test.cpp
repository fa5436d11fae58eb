// Payloads that other DDS implementations have encoded arrive as if SFT had published them.
#include <builtin_interfaces/msg/Time.hpp>

#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using builtin_interfaces::msg::Time;

class ForeignPayloadTest : public ::testing::Test {
 protected:
  ForeignPayloadTest() {
    EXPECT_TRUE(eventually([&] { return !pub.status().readers.empty() && pub.status().readers[0].served; }));
  }

  /// Returns the payload of a Time with sec = 1 and nanosec = 2.
  static std::vector<std::byte> payload(std::uint8_t encoding, bool little_endian) {
    std::vector<std::byte> bytes(12);
    bytes[1] = std::byte{encoding};
    bytes[little_endian ? 4 : 7] = std::byte{1};
    bytes[little_endian ? 8 : 11] = std::byte{2};
    return bytes;
  }

  Node node = Node::open(node_options(Way::udp, "a")).value();
  Publisher<Time> pub = node.publisher<Time>("time").value();
  Subscriber<Time, all<Time>> sub = node.subscriber<Time, all<Time>>("time").value();
};

TEST_F(ForeignPayloadTest, ThatArePlainArriveInOurEncoding) {
  for (const int encoding : {0x00, 0x01, 0x06, 0x07, 0x10, 0x11}) {
    const auto sent = pub.publish_cdr(payload(static_cast<std::uint8_t>(encoding), encoding % 2 == 1));
    ASSERT_TRUE(sent) << sent.error().message;
    ASSERT_TRUE(sub.wait(hang_timeout));
    const auto sample = sub.take();
    ASSERT_TRUE(sample);
    EXPECT_EQ(sample->sec(), 1);
    EXPECT_EQ(sample->nanosec(), 2U);
    EXPECT_EQ(sample.cdr().size(), 12U);
    EXPECT_EQ(sample.cdr()[1], std::byte{1});
  }
}

TEST_F(ForeignPayloadTest, ThatAreDelimitedAreRefusedWithWhatToDo) {
  const auto sent = pub.publish_cdr(payload(0x09, true));
  ASSERT_FALSE(sent);
  EXPECT_NE(sent.error().message.find("D_CDR2_LE"), std::string::npos) << sent.error().message;
  EXPECT_NE(sent.error().message.find("@final"), std::string::npos) << sent.error().message;
}

TEST_F(ForeignPayloadTest, ThatAreShorterThanTheTypeAreRefused) {
  auto bytes = payload(0x06, false);
  bytes.resize(10);
  EXPECT_FALSE(pub.publish_cdr(bytes));
}

}  // namespace
}  // namespace sft::test
