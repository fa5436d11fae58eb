// Tests that each change of a request of this node makes a newer request, and that nothing else does.
#include "core/negotiation/own_request.h"

#include <gmock/gmock.h>

#include <utility>

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class OwnRequestTest : public ::testing::Test {
 protected:
  static constexpr EndpointId writer = 7;
  static FieldMask mask(std::uint64_t bits) { return FieldMask::from_words(8, std::vector{bits}); }
  /// Returns the growth of the sequence since the last call.
  std::uint64_t newer() { return request.sequence - std::exchange(seen_, request.sequence); }

  Request request{
      .reader = 200, .sequence = 1, .mask_words = {}, .listening = {}, .attached = {}, .begun = {}};
  OwnRequest own{request};

 private:
  std::uint64_t seen_ = 1;
};

TEST_F(OwnRequestTest, OtherFieldsOrAnotherRateMakeANewerRequestAndTheSameOnesDoNot) {
  EXPECT_TRUE(own.needs(mask(3)));
  EXPECT_TRUE(own.takes_a_sample_per(1000));
  EXPECT_EQ(newer(), 2U);
  EXPECT_FALSE(own.needs(mask(3)));
  EXPECT_FALSE(own.takes_a_sample_per(1000));
  EXPECT_EQ(newer(), 0U);
}

TEST_F(OwnRequestTest, AConnectionIsNamedByThePathThatItTakes) {
  EXPECT_TRUE(own.connection_changed(writer, TransportKind::udp, true));
  EXPECT_THAT(request.listening, ElementsAre(writer));
  EXPECT_THAT(request.attached, IsEmpty());
  EXPECT_FALSE(own.connection_changed(writer, TransportKind::udp, true));
  EXPECT_TRUE(own.connection_changed(writer, TransportKind::shm, true));
  EXPECT_THAT(request.attached, ElementsAre(writer));
  EXPECT_EQ(newer(), 2U);
}

TEST_F(OwnRequestTest, AHistoryBeginsAgainOnceTheReaderListensToTheWriterNoMore) {
  own.connection_changed(writer, TransportKind::udp, true);
  own.connection_changed(writer, TransportKind::shm, true);
  EXPECT_TRUE(own.history_began(writer));
  EXPECT_FALSE(own.history_began(writer));
  own.connection_changed(writer, TransportKind::shm, false);
  EXPECT_THAT(request.begun, ElementsAre(writer)) << "it came over the network";
  own.connection_changed(writer, TransportKind::udp, false);
  EXPECT_THAT(request.begun, IsEmpty());
}

TEST_F(OwnRequestTest, LostMemoryEndsAllAttachmentsInOneNewerRequest) {
  EXPECT_FALSE(own.memory_lost());
  own.connection_changed(writer, TransportKind::shm, true);
  own.connection_changed(writer + 1, TransportKind::shm, true);
  newer();
  EXPECT_TRUE(own.memory_lost());
  EXPECT_THAT(request.attached, IsEmpty());
  EXPECT_EQ(newer(), 1U);
}

}  // namespace
}  // namespace sft::core
