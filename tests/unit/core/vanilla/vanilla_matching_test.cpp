// If a reader or writer of plain DDS cannot be matched, a text names the policy that does not fit.
#include "core/vanilla/vanilla_matching.h"

#include <gmock/gmock.h>

#include "core/discovery/participant_data.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* imu = "sensor_msgs::msg::dds_::Imu_";

std::string why_not(const Qos& publisher, const VanillaEndpoint& reader) {
  return why_not_served(imu, offered_to_vanilla(publisher), reader);
}
VanillaEndpoint reader_with(const Qos& qos) { return {.type_name = imu, .qos = qos}; }

TEST(VanillaMatching, APublisherOfAnyReliabilityServesReliableReaders) {
  EXPECT_THAT(
      why_not({.reliability = Reliability::best_effort}, reader_with({.reliability = Reliability::reliable})),
      IsEmpty());
}

TEST(VanillaMatching, OnlyAPublisherThatRetainsServesLatchedReaders) {
  const VanillaEndpoint latched = reader_with({.durability = Durability::transient_local});
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
  VanillaEndpoint reader = reader_with({});
  reader.is_keyed = true;
  EXPECT_THAT(why_not({}, reader), HasSubstr("keys"));
  reader = reader_with({});
  reader.has_xcdr1 = false;
  EXPECT_THAT(why_not({}, reader), HasSubstr("@final"));
  reader = reader_with({});
  reader.owns_exclusively = true;
  EXPECT_THAT(why_not({}, reader), HasSubstr("ownership"));
}

TEST(VanillaMatching, OnlyTheDefaultPartitionIsServed) {
  VanillaEndpoint reader = reader_with({});
  reader.partitions = {"left"};
  EXPECT_THAT(why_not({}, reader), HasSubstr("left"));
  reader.partitions = {"left", ""};
  EXPECT_THAT(why_not({}, reader), IsEmpty());
  reader.partitions = {"*"};
  EXPECT_THAT(why_not({}, reader), IsEmpty());
}

std::string why_not_hear(const Qos& subscriber, const VanillaEndpoint& writer, const char* type_hash = "") {
  return why_not_heard(imu, type_hash, requested_from_vanilla(subscriber), writer);
}

TEST(VanillaMatching, ASubscriberHearsWhatOffersAtLeastWhatItRequests) {
  const VanillaEndpoint lossy{.type_name = imu};
  const VanillaEndpoint latched{
      .type_name = imu,
      .qos = {.reliability = Reliability::reliable, .durability = Durability::transient_local}};
  EXPECT_THAT(why_not_hear({}, lossy), IsEmpty());
  EXPECT_THAT(why_not_hear({}, latched), IsEmpty());
  EXPECT_THAT(why_not_hear({.reliability = Reliability::reliable}, lossy), HasSubstr("reliability"));
  EXPECT_THAT(why_not_hear({.durability = Durability::transient_local}, latched), IsEmpty());
}

TEST(VanillaMatching, RetainedSamplesAreRequestedReliably) {
  const Qos requested = requested_from_vanilla({.durability = Durability::transient_local});
  EXPECT_EQ(requested.reliability, Reliability::reliable);
  EXPECT_EQ(requested_from_vanilla({}), Qos{});
}

TEST(VanillaMatching, WritersThatCannotBeHeardAreTold) {
  VanillaEndpoint writer{.type_name = "other"};
  EXPECT_THAT(why_not_hear({}, writer), HasSubstr("'other'"));
  writer = {.type_name = imu, .has_xcdr1 = false};
  EXPECT_THAT(why_not_hear({}, writer), HasSubstr("@final"));
  writer = {.type_name = imu, .is_keyed = true};
  EXPECT_THAT(why_not_hear({}, writer), HasSubstr("keys"));
  writer = {.type_name = imu, .partitions = {"left"}};
  EXPECT_THAT(why_not_hear({}, writer), HasSubstr("left"));
}

TEST(VanillaMatching, DefinitionsAreComparedByTheirHashesIfBothSidesHaveOne) {
  const VanillaEndpoint writer{.type_name = imu, .type_hash = "RIHS01_1"};
  EXPECT_THAT(why_not_hear({}, writer, "RIHS01_2"), AllOf(HasSubstr("RIHS01_1"), HasSubstr("RIHS01_2")));
  EXPECT_THAT(why_not_hear({}, writer, "RIHS01_1"), IsEmpty());
  EXPECT_THAT(why_not_hear({}, writer), IsEmpty());
  EXPECT_THAT(why_not_hear({}, {.type_name = imu}, "RIHS01_2"), IsEmpty());
}

TEST(VanillaMatching, TheHashIsFoundInTheUserDataOfROS2) {
  EXPECT_EQ(type_hash_in("typehash=RIHS01_00;"), "RIHS01_00");
  EXPECT_EQ(type_hash_in("a=b;typehash=RIHS01_00"), "RIHS01_00");
  EXPECT_EQ(type_hash_in(endpoint_user_data("RIHS01_00", 7)), "RIHS01_00");
  EXPECT_EQ(type_hash_in("enclave=/;"), "");
  EXPECT_EQ(type_hash_in(";;"), "");
}

TEST(VanillaMatching, EndpointsOfSftAreKnownByTheirMarkWhateverElseTheySay) {
  EXPECT_TRUE(is_of_sft(endpoint_user_data("", 7)));
  EXPECT_TRUE(is_of_sft(endpoint_user_data("RIHS01_00", 7)));
  EXPECT_FALSE(is_of_sft("typehash=RIHS01_00;"));
  EXPECT_FALSE(is_of_sft("notsft=1;"));
  EXPECT_FALSE(is_of_sft(""));
}

TEST(VanillaMatching, EndpointsOfSftSayIfSomeReaderDoesNotAnswer) {
  EXPECT_TRUE(is_answered_in(endpoint_user_data("RIHS01_00", 7)));
  EXPECT_FALSE(is_answered_in(endpoint_user_data("RIHS01_00", 7, false)));
  EXPECT_EQ(id_in(endpoint_user_data("RIHS01_00", 7, false)), 7U);
  EXPECT_TRUE(is_of_sft(endpoint_user_data("", 7, false)));
}

TEST(VanillaMatching, EndpointsOfSftNameTheirPublisherOrSubscriber) {
  constexpr EndpointId greatest = ~EndpointId{0};
  EXPECT_EQ(id_in(endpoint_user_data("RIHS01_00", greatest)), greatest);
  EXPECT_EQ(id_in(endpoint_user_data("", 7)), 7U);
  for (const char* text : {"", "sft=1;", "sft_id=;", "sft_id=x;", "sft_id=99999999999999999999;"})
    EXPECT_EQ(id_in(text), 0U) << text;
}

}  // namespace
}  // namespace sft::core
