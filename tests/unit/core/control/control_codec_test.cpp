// Samples of the control topics are checked before the core sees them.
#include "core/control/control_codec.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

Endpoint endpoint() {
  Endpoint e;
  e.id = 7;
  e.role = Role::reader;
  e.node_id = 8;
  e.life_lease = std::chrono::milliseconds(14'000);
  e.node = "perception";
  e.topic = "points";
  e.given_topic = "~/cloud";
  e.type_name = "sensor_msgs::msg::PointCloud2";
  e.type_hash = 0x123456789abcdef0;
  e.type_description = {std::byte{1}, std::byte{2}, std::byte{3}};
  e.host.bytes.fill(5);
  e.memory_failure = "/dev/shm is too small";
  e.network = 9;
  e.may_use_memory = true;
  e.may_use_network = true;
  e.addresses = {{0x0a000001, 4000, 1 << 20}, {loopback_ipv6, 4000, 1 << 20, true}};
  e.doorbell = {77, 3};
  e.max_sample_bytes = 1 << 24;
  e.waits = true;
  e.qos = {.reliability = reliable,
           .durability = transient_local,
           .deadline = std::chrono::milliseconds(5),
           .liveliness = manual_by_topic,
           .liveliness_lease = std::chrono::seconds(2),
           .lifespan = std::chrono::minutes(1),
           .history_depth = 17};
  e.request = {.reader = 7,
               .sequence = 4,
               .mask_words = {1, 2},
               .min_period_us = 100'000,
               .parts = {std::byte{1}, std::byte{0}, std::byte{7}},
               .listening = {6},
               .attached = {8, 9},
               .begun = {9}};
  e.revision = 11;
  return e;
}

TEST(ControlCodecTest, EndpointsAndRequestsComeBackAsTheyWere) {
  ControlStorage storage;
  EXPECT_EQ(from_dds(to_dds(endpoint(), storage)), endpoint());
  EXPECT_EQ(from_dds(to_dds(endpoint().request, storage)), endpoint().request);
  const Assertion living{8, {3, 4}, {{3, 12, 1000}, {5, 1, 0}}, 0xabcdef};
  ControlStorage of_living;
  EXPECT_EQ(from_dds(to_dds(living, of_living)), living);
}

TEST(ControlCodecTest, AReadersWordIsItsAnnouncementUnderItsKeyOrItsRequestAndNothingElse) {
  constexpr std::uint64_t key = 77;
  ControlStorage storage, of_request;
  const Endpoint reader = endpoint();
  sft_control_Endpoint announcement = to_dds(reader, storage);
  announcement.instance = key;
  sft_control_Request request = to_dds(reader.request, of_request);
  EXPECT_EQ(std::get<Endpoint>(from_dds(in_word(announcement)).value()), reader);
  EXPECT_EQ(std::get<Request>(from_dds(in_word(request, key)).value()), reader.request);

  const auto is_refused = [&](auto spoil) {
    sft_control_ReaderWord word = in_word(announcement);
    spoil(word);
    return !from_dds(word);
  };
  EXPECT_FALSE(is_refused([](auto&) {}));
  EXPECT_TRUE(is_refused([](auto& word) { word.instance = 6; })) << "another key";
  EXPECT_TRUE(is_refused([](auto& word) { word.part = 1; }));
  EXPECT_TRUE(is_refused([](auto& word) { word.part = 2; }));
  EXPECT_TRUE(is_refused([](auto& word) { word.announcement._length = 0; }));
  EXPECT_TRUE(is_refused([&](auto& word) { word.request = in_word(request, key).request; })) << "both";
}

Assertion with_accounts() {
  Assertion sign{.node = 8, .writers = {3}};
  sign.asked_about = {21, 22};
  sign.accounts = {
      {.id = {{3, 21}, Role::writer},
       .by_writer =
           {.sent = 1, .withheld = 2, .dropped = 3, .retained = 4, .bytes_sent = 5, .bytes_saved = 6}},
      {.id = {{22, 4}, Role::reader}, .by_reader = {.received = 7, .lost = 8}}};
  return sign;
}

TEST(ControlCodecTest, QuestionsAboutAccountsAndAnswersComeBackAsTheyWere) {
  ControlStorage storage;
  EXPECT_EQ(from_dds(to_dds(with_accounts(), storage)), with_accounts());
}

TEST(ControlCodecTest, ASignOfLifeWithoutNewsIsAsShortAsCanBeAndAWishIsNews) {
  ControlStorage storage;
  Assertion sign{.node = 8, .writers = {}, .digest_of_writers = 0x123456, .digest_of_readers = 0x789abc};
  EXPECT_FALSE(to_dds(sign, storage).news._d);
  EXPECT_EQ(from_dds(to_dds(sign, storage)), sign);
  sign.wants_signs = true;
  EXPECT_EQ(from_dds(to_dds(sign, storage)), sign);
}

TEST(ControlCodecTest, MoreQuestionsAndAccountsThanASignOfLifeHasRoomForAreNotWritten) {
  Assertion sign = with_accounts();
  sign.asked_about.resize(1000, 21);
  sign.accounts.resize(1000, sign.accounts[0]);
  ControlStorage storage;
  const auto back = from_dds(to_dds(sign, storage)).value();
  EXPECT_EQ(back.asked_about.size(), asked_about_max);
  EXPECT_EQ(back.accounts.size(), accounts_max);
}

TEST(ControlCodecTest, ASignOfLifeWithMoreThanThereMayBeIsRefusedBeforeItIsRead) {
  const auto refusal = [](auto spoil) {
    ControlStorage storage;
    const Assertion sign = with_accounts();  // the sample refers to it
    sft_control_Assertion sample = to_dds(sign, storage);
    spoil(sample);
    const auto decoded = from_dds(sample);
    return decoded ? "" : decoded.error().message;
  };
  EXPECT_EQ(refusal([](auto&) {}), "");
  EXPECT_EQ(refusal([](auto& s) { s.news._u.news.accounts._length = 33; }),
            "a sign of life with 33 accounts, of which 32 are the most");
  EXPECT_EQ(refusal([](auto& s) { s.news._u.news.asked_about._length = 65; }),
            "a sign of life with 65 endpoints that are asked about, of which 64 are the most");
  EXPECT_NE(refusal([](auto& s) { s.news._u.news.progress._length = UINT32_MAX; }), "");
  EXPECT_NE(refusal([](auto& s) { s.news._u.news.writers._length = UINT32_MAX; }), "");
}

TEST(ControlCodecTest, AnAccountThatNeitherSideSaysIsRefused) {
  ControlStorage storage;
  const Assertion sign = with_accounts();
  const sft_control_Assertion sample = to_dds(sign, storage);
  storage.accounts[1].said_by = 2;
  EXPECT_FALSE(from_dds(sample));
}

TEST(ControlCodecTest, WhatOneSideSaysOfTheOtherSidesCountsIsLeftOut) {
  ControlStorage storage;
  const Assertion sign = with_accounts();
  const sft_control_Assertion sample = to_dds(sign, storage);
  storage.accounts[0].lost = 99;
  storage.accounts[1].sent = 99;
  EXPECT_EQ(from_dds(sample), sign);
}

TEST(ControlCodecTest, WhatIsLongerThanTheTopicAllowsIsCutAndNotWrittenBeyond) {
  Endpoint e = endpoint();
  e.node = std::string(1000, 'n');
  e.addresses.resize(20, e.addresses[0]);
  e.request.attached.resize(2000, 1);
  e.request.begun.resize(2000, 1);
  ControlStorage storage;
  const auto back = from_dds(to_dds(e, storage)).value();
  EXPECT_EQ(back.node.size(), 255U);
  EXPECT_EQ(back.addresses.size(), 16U);
  EXPECT_EQ(back.request.attached.size(), 1024U);
  EXPECT_EQ(back.request.begun.size(), 1024U);
}

TEST(ControlCodecTest, ATypeDescriptionBeyondTheLimitIsLeftOutWhole) {
  Endpoint e = endpoint();
  e.type_description.resize(type_description_bytes_max);
  ControlStorage storage;
  EXPECT_EQ(from_dds(to_dds(e, storage))->type_description.size(), type_description_bytes_max);
  e.type_description.resize(type_description_bytes_max + 1);
  EXPECT_TRUE(from_dds(to_dds(e, storage))->type_description.empty());
}

TEST(ControlCodecTest, AnotherProtocolVersionIsRefusedByName) {
  ControlStorage storage;
  sft_control_Endpoint sample = to_dds(endpoint(), storage);
  sample.version = 1;
  const auto result = from_dds(sample);
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().message.find("version 1"), std::string::npos);
}

TEST(ControlCodecTest, SamplesThatNameNothingAreRefused) {
  ControlStorage storage;
  sft_control_Endpoint sample = to_dds(endpoint(), storage);
  sample.role = 2;
  EXPECT_FALSE(from_dds(sample));
  sample = to_dds(endpoint(), storage);
  sample.topic[0] = '\0';
  EXPECT_FALSE(from_dds(sample));
  sample = to_dds(endpoint(), storage);
  sample.id = 0;
  EXPECT_FALSE(from_dds(sample));
  EXPECT_FALSE(from_dds(to_dds(Request{}, storage)));
}

TEST(ControlCodecTest, NamesThatCouldForgeLinesOfALogAreRefusedAndQuotedSafely) {
  const auto refusal = [](auto spoil) {
    ControlStorage storage;
    Endpoint e = endpoint();
    spoil(e);
    const auto decoded = from_dds(to_dds(e, storage));
    return decoded ? "" : decoded.error().message;
  };
  EXPECT_EQ(refusal([](Endpoint& e) { e.node = "x\n[error] disk full"; }),
            "an endpoint whose node name 'x\\x0a[error] disk full' has a control character in it");
  EXPECT_EQ(refusal([](Endpoint& e) { e.topic = "a\xff"; }), "an endpoint whose topic 'a\\xff' is not UTF-8");
  EXPECT_EQ(refusal([](Endpoint& e) { e.topic = "//a"; }),
            "an endpoint whose topic '//a' has nothing between two slashes");
  EXPECT_EQ(refusal([](Endpoint& e) { e.given_topic = "a\nb"; }),
            "an endpoint whose program's topic 'a\\x0ab' has a control character in it");
  EXPECT_EQ(refusal([](Endpoint& e) { e.type_name = "a\x1b[2J"; }),
            "an endpoint whose type name 'a\\x1b[2J' has a control character in it");
  EXPECT_EQ(refusal([](Endpoint& e) { e.node = ""; }), "") << "a node needs no name";
}

TEST(ControlCodecTest, AReasonThatIsNoTextIsLeftOutAndItsEndpointIsNotRefused) {
  for (const std::string& text :
       {std::string("a\x1b[2J"), std::string("\xff"), std::string(254, 'a') + "\xc3\xa4"}) {
    ControlStorage storage;
    Endpoint e = endpoint();
    e.memory_failure = text;
    const auto decoded = from_dds(to_dds(e, storage));
    ASSERT_TRUE(decoded) << decoded.error().message;
    EXPECT_EQ(decoded->memory_failure, "");
  }
}

TEST(ControlCodecTest, ATopicThatSomebodyAnnouncesWithASlashInFrontIsTheOneWithoutIt) {
  ControlStorage storage;
  Endpoint e = endpoint();
  e.topic = "/points";
  EXPECT_EQ(from_dds(to_dds(e, storage)), endpoint());
}

TEST(ControlCodecTest, SequencesThatNoReaderComesToAreRefused) {
  ControlStorage storage;
  Request request = endpoint().request;
  request.sequence = request_sequence_max;
  EXPECT_TRUE(from_dds(to_dds(request, storage)));
  request.sequence = request_sequence_max + 1;
  EXPECT_FALSE(from_dds(to_dds(request, storage)));
  Endpoint e = endpoint();
  e.request.sequence = UINT64_MAX;
  EXPECT_FALSE(from_dds(to_dds(e, storage)));
}

TEST(ControlCodecTest, PoliciesThatDoNotExistAreRefused) {
  const auto refused = [](auto spoil) {
    ControlStorage storage;
    const Endpoint e = endpoint();  // the sample refers to it
    sft_control_Endpoint sample = to_dds(e, storage);
    spoil(sample.qos);
    return !from_dds(sample);
  };
  EXPECT_TRUE(refused([](auto& qos) { qos.reliability = 2; }));
  EXPECT_TRUE(refused([](auto& qos) { qos.durability = 2; }));
  EXPECT_TRUE(refused([](auto& qos) { qos.liveliness = 2; }));
  EXPECT_TRUE(refused([](auto& qos) { qos.deadline = UINT64_MAX; }));
  EXPECT_TRUE(refused([](auto& qos) { qos.liveliness_lease = UINT64_MAX; }));
  EXPECT_TRUE(refused([](auto& qos) { qos.lifespan = UINT64_MAX; }));
}

TEST(ControlCodecTest, AddressesWithoutPortAreLeftOut) {
  Endpoint e = endpoint();
  e.addresses[0].port = 0;
  ControlStorage storage;
  EXPECT_EQ(from_dds(to_dds(e, storage))->addresses.size(), 1U);
}

TEST(ControlCodecTest, AddressesOfUnknownFamiliesAndOfNoSocketAreLeftOut) {
  const auto left_out = [](auto spoil) {
    ControlStorage storage;
    const Endpoint e = endpoint();  // the sample refers to it
    sft_control_Endpoint sample = to_dds(e, storage);
    spoil(storage.addresses[0]);
    return from_dds(sample)->addresses == std::vector(1, e.addresses[1]);
  };
  EXPECT_TRUE(left_out([](auto& locator) { locator.family = 5; }));
  EXPECT_TRUE(left_out([](auto& locator) { locator.family = 6; })) << "it is one of IPv4";
  EXPECT_TRUE(left_out([](auto& locator) { locator.address[12] = 224; })) << "it is a multicast address";
  EXPECT_TRUE(left_out([](auto& locator) { std::fill_n(locator.address, 16, std::uint8_t{0}); }));
}

}  // namespace
}  // namespace sft::core
