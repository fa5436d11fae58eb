// These tests check which destinations may share a multicast group at all.
#include "udp_transport/multicast/divisions.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/unit/udp/messages.h"

namespace sft::udp {
namespace {

using test::Image;
using test::selection_of;

core::Wanted wanted(const std::string& text, std::uint32_t min_period_us = 0) {
  return {selection_of<Image>(text).without_rate(), min_period_us};
}

std::vector<Division> divided(const std::vector<DividedPlace>& places) { return divide(places); }

TEST(Divisions, OfPlacesThatAreSentEverySampleAreTheirLinks) {
  const std::vector<Division> all = divided({{0}, {1}, {0}});
  EXPECT_EQ(all[0].number, all[2].number);
  EXPECT_NE(all[0].number, all[1].number);
  for (const Division& one : all) EXPECT_EQ(one.refusal, "");
}

TEST(Divisions, OfPlacesThatAreSentSomeSamplesAskForTheSameOfTheSameSamples) {
  const core::Wanted rated = wanted("data", 1000), slower = wanted("data", 2000);
  const core::Wanted other = wanted("name", 1000);
  const core::Wanted changes = wanted("data @ changed(height)");
  const std::vector<Division> all = divided(
      {{0}, {0, &rated}, {0, &slower}, {0, &other}, {0, &changes}, {1, &rated}, {0, &rated}, {0, &changes}});
  EXPECT_EQ(all[1].number, all[6].number);
  EXPECT_EQ(all[4].number, all[7].number);
  for (const int shared : {0, 1, 4, 6, 7}) EXPECT_EQ(all.at(shared).refusal, "") << shared;
  for (const int lonely : {2, 3, 5}) EXPECT_NE(all.at(lonely).refusal, "") << lonely;
  EXPECT_NE(all[0].number, all[1].number) << "not every sample of the first is for the second";
  EXPECT_NE(all[1].number, all[4].number);
}

TEST(Divisions, OfSomeSamplesAreLimitedBehindALinkAndTheMostWantedOnesComeFirst) {
  std::vector<core::Wanted> kinds;
  for (std::uint32_t i = 0; i <= some_samples_groups_max; ++i) kinds.push_back(wanted("data", 1000 + i));
  std::vector<DividedPlace> places{{0}};
  for (const core::Wanted& kind : kinds) places.insert(places.end(), 2, {0, &kind});
  places.insert(places.end(), 2, {1, &kinds[0]});
  places.push_back({0, &kinds.back()});
  const std::vector<Division> all = divide(places);
  std::size_t refused = 0;
  for (const Division& one : all) refused += one.refusal.empty() ? 0 : 1;
  EXPECT_EQ(refused, 2U);
  EXPECT_EQ(all.front().refusal, "");
  EXPECT_EQ(all.back().refusal, "") << "three readers ask for it";
}

TEST(Divisions, ThatAreSentMoreComeBeforeThoseThatMoreReadersAskFor) {
  std::vector<core::Wanted> kinds;
  for (std::uint32_t i = 0; i <= some_samples_groups_max; ++i) kinds.push_back(wanted("data", 1000 + i));
  std::vector<DividedPlace> places;
  for (const core::Wanted& kind : kinds) places.insert(places.end(), 3, {0, &kind, false, 10});
  places.erase(places.end() - 1);
  EXPECT_NE(divided(places).back().refusal, "");
  places.back().bytes_per_s = 1000;
  EXPECT_EQ(divided(places).back().refusal, "");
}

TEST(Divisions, ThatHaveAGroupKeepItWhateverOthersAskFor) {
  std::vector<core::Wanted> kinds;
  for (std::uint32_t i = 0; i <= some_samples_groups_max; ++i) kinds.push_back(wanted("data", 1000 + i));
  std::vector<DividedPlace> places;
  for (const core::Wanted& kind : kinds) places.insert(places.end(), 3, {0, &kind});
  places.erase(places.end() - 1);
  places.back().is_in_group = true;
  EXPECT_EQ(divided(places).back().refusal, "");
  places.back().is_in_group = false;
  EXPECT_NE(divided(places).back().refusal, "");
}

}  // namespace
}  // namespace sft::udp
