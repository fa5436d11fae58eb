// The message by which nodes of ROS 2 announce themselves is written and read in both of its sizes. All
// other bytes are refused.
#include "core/vanilla/participant_entities.h"

#include <gmock/gmock.h>

#include "tests/support/test_seed.h"

namespace sft::core {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

constexpr GuidBytes both_sizes[] = {GuidBytes::as_of_iron, GuidBytes::before_iron};

Guid filled(std::uint8_t number) {
  Guid guid{};
  guid.fill(number);
  return guid;
}

ParticipantEntities of_camera() {
  return {
      .participant = filled(1),
      .nodes = {{.name_space = "/", .name = "sft_camera", .readers = {filled(2)}, .writers = {filled(3)}}}};
}

TEST(ParticipantEntities, HaveTheSizesThatRosMakesThem) {
  constexpr std::size_t encapsulation = 4;
  EXPECT_THAT(encode_entities(of_camera(), GuidBytes::as_of_iron), SizeIs(88 - encapsulation));
  EXPECT_THAT(encode_entities(of_camera(), GuidBytes::before_iron), SizeIs(112 - encapsulation));
  EXPECT_THAT(encode_entities({}, GuidBytes::as_of_iron), SizeIs(20));
  EXPECT_THAT(encode_entities({}, GuidBytes::before_iron), SizeIs(28));
}

TEST(ParticipantEntities, AreReadInTheSizeInWhichTheyWereWritten) {
  ParticipantEntities two = of_camera();
  two.nodes.push_back(
      {.name_space = "/left", .name = "lidar", .readers = {}, .writers = {filled(4), filled(5)}});
  for (const GuidBytes size : both_sizes) {
    std::vector<std::byte> body = encode_entities(two, size);
    for (std::size_t padding = 0; padding < 4; ++padding, body.emplace_back()) {
      const auto read = decode_entities(body);
      ASSERT_TRUE(read) << padding;
      EXPECT_EQ(read->guid_bytes, size);
      EXPECT_EQ(read->entities.participant, filled(1));
      ASSERT_THAT(read->entities.nodes, SizeIs(2));
      EXPECT_EQ(read->entities.nodes[0].name, "sft_camera");
      EXPECT_THAT(read->entities.nodes[0].readers, ElementsAre(filled(2)));
      EXPECT_EQ(read->entities.nodes[1].name_space, "/left");
      EXPECT_THAT(read->entities.nodes[1].writers, ElementsAre(filled(4), filled(5)));
    }
    EXPECT_FALSE(decode_entities(body)) << "four bytes are no padding";
  }
}

TEST(ParticipantEntities, WithoutNodesHaveASizeAsWell) {
  for (const GuidBytes size : both_sizes) {
    const auto read = decode_entities(encode_entities({.participant = filled(1)}, size));
    ASSERT_TRUE(read);
    EXPECT_EQ(read->guid_bytes, size);
    EXPECT_TRUE(read->entities.nodes.empty());
  }
}

TEST(ParticipantEntities, ThatAreCutOffAreRefused) {
  for (const GuidBytes size : both_sizes) {
    const std::vector<std::byte> body = encode_entities(of_camera(), size);
    // A shorter part of the longer message is a whole one of the other size, without nodes.
    const std::size_t shortest = size == GuidBytes::before_iron ? 24 : 0;
    for (std::size_t bytes = shortest; bytes < body.size(); ++bytes)
      EXPECT_FALSE(decode_entities(std::span(body).first(bytes))) << bytes;
  }
}

TEST(ParticipantEntities, WithALongNameOrOneWithoutAnEndAreRefused) {
  ParticipantEntities entities = of_camera();
  entities.nodes[0].name = std::string(256, 'a');
  EXPECT_TRUE(decode_entities(encode_entities(entities, GuidBytes::as_of_iron)));
  entities.nodes[0].name = std::string(257, 'a');
  EXPECT_FALSE(decode_entities(encode_entities(entities, GuidBytes::as_of_iron)));
  std::vector<std::byte> body = encode_entities(of_camera(), GuidBytes::as_of_iron);
  body[25] = std::byte{'x'};  // in place of the NUL of the namespace
  EXPECT_FALSE(decode_entities(body));
}

using ForgedEntities = test::RandomTest;

TEST_F(ForgedEntities, AreSafeToReadWhateverTheirBytesAre) {
  for (std::uint64_t round = 0; round < test::test_rounds(20'000); ++round) {
    std::vector<std::byte> body = encode_entities(of_camera(), both_sizes[round % 2]);
    for (std::uint64_t changes = random() % 4 + 1; changes > 0; --changes)
      body[random() % body.size()] = static_cast<std::byte>(random());
    const auto read = decode_entities(body);
    EXPECT_TRUE(!read || read->entities.nodes.size() < body.size());
  }
}

TEST(ParticipantEntities, HaveTheSizeOfTheDistributionAndNoneForAnUnknownOne) {
  EXPECT_EQ(guid_bytes_of("humble"), GuidBytes::before_iron);
  EXPECT_EQ(guid_bytes_of("iron"), GuidBytes::as_of_iron);
  EXPECT_EQ(guid_bytes_of("jazzy"), GuidBytes::as_of_iron);
  for (const char* unknown : {"", "noetic", "Humble", "jazzy2"})
    EXPECT_FALSE(guid_bytes_of(unknown)) << unknown;
}

}  // namespace
}  // namespace sft::core
