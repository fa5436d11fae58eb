// For a reader of plain DDS that is not served, the policy that does not fit is named in words.
#include "core/vanilla/vanilla_matching.h"

#include <gmock/gmock.h>

#include "core/discovery/participant_data.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* imu = "sensor_msgs::msg::dds_::Imu_";

std::string why_not(const Qos& publisher, const VanillaReader& reader) {
  return why_not_served(imu, offered_to_vanilla(publisher), reader);
}
VanillaReader reader_with(const Qos& qos) { return {.type_name = imu, .qos = qos}; }

TEST(VanillaMatching, APublisherOfAnyReliabilityServesReliableReaders) {
  EXPECT_THAT(
      why_not({.reliability = Reliability::best_effort}, reader_with({.reliability = Reliability::reliable})),
      IsEmpty());
}

TEST(VanillaMatching, OnlyAPublisherThatRetainsServesLatchedReaders) {
  const VanillaReader latched = reader_with({.durability = Durability::transient_local});
  EXPECT_THAT(why_not({.durability = Durability::transient_local}, latched), IsEmpty());
  EXPECT_THAT(why_not({}, latched), HasSubstr("durability"));
}

TEST(VanillaMatching, ADeadlineHasToBePromised) {
  EXPECT_THAT(why_not({}, reader_with({.deadline = 1s})), HasSubstr("deadline"));
  EXPECT_THAT(why_not({.deadline = 1s}, reader_with({.deadline = 2s})), IsEmpty());
}

TEST(VanillaMatching, NoLeaseAndNoSignOfLifeOfATopicIsPromised) {
  const Qos promises{.liveliness = Liveliness::manual_by_topic, .liveliness_lease = 1s};
  EXPECT_THAT(why_not(promises, reader_with({.liveliness_lease = 2s})), HasSubstr("lease"));
  EXPECT_THAT(why_not(promises, reader_with({.liveliness = Liveliness::manual_by_topic})),
              HasSubstr("liveliness"));
}

TEST(VanillaMatching, AnotherTypeIsNamed) {
  EXPECT_THAT(why_not({}, {.type_name = "other"}), HasSubstr("'other'"));
}

TEST(VanillaMatching, KeysRepresentationAndOwnershipAreNamed) {
  VanillaReader reader = reader_with({});
  reader.is_keyed = true;
  EXPECT_THAT(why_not({}, reader), HasSubstr("keys"));
  reader = reader_with({});
  reader.takes_xcdr1 = false;
  EXPECT_THAT(why_not({}, reader), HasSubstr("@final"));
  reader = reader_with({});
  reader.owns_exclusively = true;
  EXPECT_THAT(why_not({}, reader), HasSubstr("ownership"));
}

TEST(VanillaMatching, OnlyTheDefaultPartitionIsServed) {
  VanillaReader reader = reader_with({});
  reader.partitions = {"left"};
  EXPECT_THAT(why_not({}, reader), HasSubstr("left"));
  reader.partitions = {"left", ""};
  EXPECT_THAT(why_not({}, reader), IsEmpty());
  reader.partitions = {"*"};
  EXPECT_THAT(why_not({}, reader), IsEmpty());
}

TEST(VanillaMatching, EndpointsOfSftAreKnownByTheirMarkWhateverElseTheySay) {
  EXPECT_TRUE(is_of_sft(endpoint_user_data("")));
  EXPECT_TRUE(is_of_sft(endpoint_user_data("RIHS01_00")));
  EXPECT_FALSE(is_of_sft("typehash=RIHS01_00;"));
  EXPECT_FALSE(is_of_sft("notsft=1;"));
  EXPECT_FALSE(is_of_sft(""));
}

}  // namespace
}  // namespace sft::core
