// These tests check which processes outside of multicast groups get one copy for all their readers.
#include "udp_transport/routing/mask_sharing.h"

#include "tests/unit/udp/routing/group_keeper_fixture.h"

namespace sft::udp::test {
namespace {

/// All readers of a test are in one process unless the test says otherwise.
class MaskSharingTest : public GroupKeeperTest {
 protected:
  MaskSharingTest() { restart(Multicast::off); }

  core::Route& here(const char* mask) { return reader(first_link + 10, mask); }
  void serve_measured(std::size_t data_bytes) {
    serve();
    publish(data_bytes);
    if (keeper_->replan(now_)) serve();
  }
  std::vector<FieldMask> masks() const {
    std::vector<FieldMask> all;
    for (const RouteBundle& bundle : merged_) all.push_back(bundle.wanted.selection.mask());
    return all;
  }
};

TEST_F(MaskSharingTest, SendsOneCopyForReadersWhoseMasksHaveMostInCommon) {
  here("data, height");
  here("data, width");
  serve();
  EXPECT_EQ(merged_.size(), 2U) << "no sample was measured yet";
  publish(1000);
  EXPECT_EQ(keeper_->next_duty(now_), now_) << "which is now";
  ASSERT_TRUE(keeper_->replan(now_));
  serve();
  ASSERT_EQ(merged_.size(), 1U);
  EXPECT_TRUE(merged_[0].merged);
  EXPECT_FALSE(merged_[0].multicast);
  EXPECT_EQ(merged_[0].wanted.selection.mask(), fields<Image>("data, height, width"));
  EXPECT_EQ(merged_[0].readers.size(), 2U);
  EXPECT_EQ(merged_[0].reliable.begin()->second, (std::set<core::EndpointId>{1, 2}));
  EXPECT_FALSE(keeper_->replan(now_)) << "nothing has changed";
}

TEST_F(MaskSharingTest, TellsWhatTheCopyAddsToWhatEachReaderAskedFor) {
  here("data, height");
  here("data, width");
  serve_measured(1000);
  EXPECT_EQ(why(1),
            "one copy for all readers of its process, which adds 4 bytes to a sample that others asked for; "
            "in no group: multicast is off by option");
}

TEST_F(MaskSharingTest, ServesAReaderOfFewFieldsBesideOneOfManyByItself) {
  here("data");
  here("height");
  serve_measured(100'000);
  EXPECT_EQ(masks(), (std::vector{fields<Image>("data"), fields<Image>("height")}))
      << "it would wait for the data, and hardly a byte would be spared";
}

TEST_F(MaskSharingTest, ServesReadersThatHaveNothingInCommonByThemselves) {
  here("data");
  here("name");
  serve();
  Image image = make_image(50'000);
  image.name.assign(50'000, 'n');
  publish(image);
  EXPECT_FALSE(keeper_->replan(now_));
  EXPECT_EQ(merged_.size(), 2U);
}

TEST_F(MaskSharingTest, SharesEachUnionAmongTheProcessesThatWantIt) {
  for (const std::uint32_t host : {10U, 11U}) {
    reader(first_link + host, "data, height");
    reader(first_link + host, "data, width");
  }
  serve_measured(1000);
  ASSERT_EQ(merged_.size(), 1U);
  EXPECT_EQ(merged_[0].destinations.size(), 2U);
  EXPECT_EQ(merged_[0].readers.size(), 4U);
}

TEST_F(MaskSharingTest, LeavesTheReadersOfAProcessApartOfWhichOneHasAMaximumRate) {
  here("data, height");
  here("data, width");
  routes_[1].gate = std::make_shared<core::Gate>(10'000);
  serve_measured(1000);
  EXPECT_EQ(merged_.size(), 2U);
}

TEST_F(MaskSharingTest, GoesOnWithTheUnionOfOtherMasks) {
  here("data, height");
  here("data, width");
  serve_measured(1000);
  routes_[1].selection = fields<Image>("data, stamp");
  serve();
  EXPECT_EQ(masks(), std::vector{fields<Image>("data, height, stamp")});
  routes_.pop_back();
  serve();
  EXPECT_EQ(masks(), std::vector{fields<Image>("data, height")});
  EXPECT_FALSE(merged_[0].merged);
}

TEST_F(MaskSharingTest, DoesNotChangeToAndFroWithSizes) {
  here("data");
  here("data, name");
  serve();
  int changes = 0;
  for (int i = 0; i < 100; ++i, now_ += 100ms) {
    Image image = make_image(1000);
    // The separate copies have sizes close to 1.05 times the size of one copy.
    image.name.assign(i / 10 % 2 == 0 ? 19'000 : 21'000, 'n');
    publish(image);
    if (!keeper_->replan(now_)) continue;
    ++changes;
    serve();
  }
  EXPECT_LE(changes, 1);
}

TEST_F(MaskSharingTest, SendsOneCopyOfTheWholeFieldForPartsThatAreMoreTogether) {
  here("data[:900]");
  here("data[100:]");
  here("height");
  serve_measured(1000);
  ASSERT_EQ(merged_.size(), 1U);
  EXPECT_EQ(merged_[0].wanted.selection, Selection(fields<Image>("data, height")));
  EXPECT_EQ(
      why(1),
      "one copy for all readers of its process, which adds 104 bytes to a sample that others asked for; "
      "in no group: multicast is off by option");
}

TEST_F(MaskSharingTest, SendsSmallPartsByThemselves) {
  here("data[:900]");
  here("data[90000:]");
  serve_measured(100'000);
  ASSERT_EQ(merged_.size(), 2U);
  EXPECT_EQ(merged_[0].wanted.selection, selection_of<Image>("data[:900]"));
}

TEST_F(MaskSharingTest, GoesOnWithTheWholeFieldWhileOneOfItsPartsMoves) {
  here("data");
  here("data[:900]");
  serve_measured(1000);
  for (int i = 0; i < 50; ++i, now_ += 10ms) {
    routes_[1].selection = selection_of<Image>("data[" + std::to_string(i) + ":990]");
    serve();
    ASSERT_EQ(merged_.size(), 1U) << "at move " << i;
    EXPECT_EQ(merged_[0].wanted.selection, Selection(fields<Image>("data")));
    publish(1000);
    EXPECT_FALSE(keeper_->replan(now_));
  }
}

TEST_F(MaskSharingTest, LeavesTheReadersOfAProcessApartOfWhichOneHasConditions) {
  here("data, height");
  here("data, width @ width > 5");
  routes_[1].gate = std::make_shared<core::Gate>(0);
  serve_measured(1000);
  EXPECT_EQ(merged_.size(), 2U);
}

/// A copy for a group has the masks of all readers of each member.
TEST_F(MaskSharingTest, LeavesMembersOfGroupsToThese) {
  restart(Multicast::automatic);
  for (const std::uint32_t host : {10U, 11U, 12U}) {
    reader(first_link + host, "data, height");
    reader(first_link + host, "data, width");
  }
  serve();
  go_on(200ms);
  ASSERT_EQ(groups_.size(), 1U);
  EXPECT_EQ(members(), 3U);
  EXPECT_EQ(merged_.size(), 1U);
}

}  // namespace
}  // namespace sft::udp::test
