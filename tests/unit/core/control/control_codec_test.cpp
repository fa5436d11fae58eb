// Samples of the control topics are checked before the core sees them.
#include "core/control/control_codec.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

TEST(ControlCodecTest, SignsOfLifeComeBackAsTheyWere) {
  const Assertion living{8, {3, 4}, {{3, 12, 1000}, {5, 1, 0}}};
  ControlStorage of_living;
  EXPECT_EQ(from_dds(to_dds(living, of_living)), living);
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

}  // namespace
}  // namespace sft::core
