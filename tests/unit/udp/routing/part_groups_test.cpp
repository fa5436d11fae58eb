// These tests check which readers that request parts of fields are put into multicast groups.
#include "tests/support/eventually.h"
#include "tests/unit/udp/routing/group_keeper_fixture.h"
#include "udp_transport/routing/routes.h"

namespace sft::udp::test {
namespace {

class PartGroupsTest : public GroupKeeperTest {
 protected:
  /// Publishes images with `data_bytes` bytes of data at 1 kHz.
  void go_on_with(std::size_t data_bytes, std::chrono::milliseconds time) {
    for (const auto end = now_ + time; now_ < end; now_ += 1ms) {
      publish(data_bytes);
      if (keeper_->replan(now_)) serve();
    }
  }
  /// Returns the selection of the first bundle with that number of readers, or an empty one if there is no
  /// such bundle.
  Selection sent_to(std::size_t readers) const {
    const auto found = std::ranges::find_if(
        merged_, [&](const RouteBundle& bundle) { return bundle.readers.size() == readers; });
    return found == merged_.end() ? Selection() : found->wanted.selection;
  }
};

TEST_F(PartGroupsTest, HostsThatAskForTheSamePartShareAGroupWithJustThatPart) {
  readers(8, "stamp, data[::3]");
  serve();
  go_on_with(100'000, 200ms);
  ASSERT_EQ(groups_.size(), 1U);
  EXPECT_EQ(members(), 8U);
  ASSERT_EQ(merged_.size(), 1U);
  EXPECT_EQ(merged_[0].wanted.selection, selection_of<Image>("stamp, data[::3]"));
  EXPECT_EQ(why(1).find(", which adds "), std::string::npos) << why(1);
}

TEST_F(PartGroupsTest, EachOfTwoLargePartsHasAGroup) {
  readers(4, "data[::3]");
  readers(3, "data[:10000]");
  serve();
  go_on_with(100'000, 200ms);
  EXPECT_EQ(groups_.size(), 2U);
  EXPECT_EQ(members(), 7U);
  EXPECT_EQ(sent_to(4), selection_of<Image>("data[::3]"));
  EXPECT_EQ(sent_to(3), selection_of<Image>("data[:10000]"));
}

TEST_F(PartGroupsTest, ManyPartsOfOneFieldAreServedByTheWholeField) {
  for (int i = 0; i < 8; ++i) readers(1, ("data[" + std::to_string(100 * i) + ":]").c_str());
  serve();
  go_on_with(100'000, 200ms);
  ASSERT_EQ(groups_.size(), 1U);
  EXPECT_EQ(members(), 8U);
  EXPECT_EQ(merged_[0].wanted.selection, Selection(fields<Image>("data")));
  EXPECT_NE(why(8).find(", which adds 700 bytes"), std::string::npos) << why(8);
  EXPECT_EQ(why(1).find(", which adds "), std::string::npos) << "it asks for the whole field: " << why(1);
}

/// Two recorders, three dashboards and a watchdog read the data of a robot. The bytes on the link are
/// limited relative to one copy. The whole field and a twentieth of it together exceed the limit, but the
/// whole field and a fiftieth of it do not.
TEST_F(PartGroupsTest, APartBesideTheWholeFieldHasAGroupOfItsOwnOnlyIfItIsSmall) {
  for (const char* part : {"data[::20]", "data[::50]"}) {
    restart(Multicast::automatic);
    routes_.clear();
    readers(2, "*");
    readers(3, part);
    readers(1, "height, width");
    serve();
    go_on_with(100'000, 200ms);
    const bool is_small = part == std::string("data[::50]");
    EXPECT_EQ(sent_to(is_small ? 2 : 5), Selection(fields<Image>("*"))) << part;
    EXPECT_EQ(sent_to(3), is_small ? selection_of<Image>(part) : Selection()) << part;
    EXPECT_EQ(members(), 5U) << part;
  }
}

TEST_F(PartGroupsTest, APartThatIsNewWaitsForASampleThatShowsHowLargeItIs) {
  readers(2, "data[::2]");
  serve();
  go_on_with(1000, 200ms);
  ASSERT_EQ(members(), 2U);
  readers(2, "data[::5]");
  serve();
  now_ += 110ms;
  EXPECT_FALSE(keeper_->replan(now_)) << "nothing was published since";
  serve();
  EXPECT_EQ(members(), 2U);
  publish(1000);
  EXPECT_TRUE(keeper_->replan(now_));
  serve();
  EXPECT_EQ(members(), 4U);
}

TEST_F(PartGroupsTest, AWindowThatMovesAllTheTimeIsServedAloneAndTheOthersNoticeNothing) {
  readers(3, "data[::3]");
  readers(1, "data[:50000]");
  serve();
  go_on_with(100'000, 200ms);
  ASSERT_GE(members(), 3U);
  routes_[3].selection = selection_of<Image>("data[7:50007]");
  serve();
  ASSERT_EQ(members(), 3U);
  const auto group = groups_.at(0);
  for (int i = 0; i < 100; ++i) {
    const std::string window = "data[" + std::to_string(i) + ":" + std::to_string(50'000 + i) + "]";
    routes_[3].selection = selection_of<Image>(window);
    serve();
    EXPECT_EQ(why(4), unsettled);
    EXPECT_EQ(sent_to(1), selection_of<Image>(window));
    go_on_with(100'000, 30ms);
    ASSERT_EQ(groups_.at(0), group) << "at move " << i;
  }
}

/// A reader of a part may subscribe to samples whose whole field exceeds the size limit of a body.
TEST_F(PartGroupsTest, NobodyIsSentMoreThanItAskedForIfThatMightBeTooMuchForASample) {
  const auto restart_with_limit = [this](Multicast use) {
    GroupKeeper::Setup limited = setup(type_support<Image>(), use, 7);
    limited.limits.merged_body_max = 50'000;
    keeper_ = std::make_unique<GroupKeeper>(std::move(limited));
    routes_.clear();
  };
  restart_with_limit(Multicast::automatic);
  for (int i = 0; i < 8; ++i) readers(1, ("data[" + std::to_string(100 * i + 1) + ":]").c_str());
  serve();
  go_on_with(100'000, 200ms);
  EXPECT_EQ(members(), 0U);
  EXPECT_EQ(merged_.size(), 8U);
  readers(3, "data");
  serve();
  go_on_with(100'000, 200ms);
  EXPECT_EQ(members(), 11U) << "a reader is sent the whole field anyway";

  restart_with_limit(Multicast::off);
  reader(first_link + 10, "data[1:]");
  reader(first_link + 10, "data[2:]");
  serve();
  go_on_with(100'000, 10ms);
  EXPECT_EQ(merged_.size(), 2U);
  reader(first_link + 10, "data");
  serve();
  go_on_with(100'000, 10ms);
  EXPECT_EQ(merged_.size(), 1U);
}

TEST_F(PartGroupsTest, ReadersWithTheSameConditionsShareAGroupOfTheirOwn) {
  for (const char* asked : {"data[::3] @ height > 4", "data @ every 2nd"}) {
    restart(Multicast::automatic);
    const std::uint64_t conditions = selection_of<Image>(asked).gate_hash();
    const auto gate = std::make_shared<core::Gate>(0, detail::Conditions(), conditions);
    routes_.clear();
    readers(2, "data[::3]");
    readers(2, asked);
    routes_[2].gate = routes_[3].gate = gate;
    serve();
    go_on_with(100'000, 200ms);
    EXPECT_EQ(groups_.size(), 2U);
    EXPECT_EQ(members(), 4U);
    const auto gated = std::ranges::find_if(merged_, [](const auto& one) { return one.gate != nullptr; });
    ASSERT_NE(gated, merged_.end());
    EXPECT_EQ(gated->gate, gate);
    EXPECT_EQ(gated->wanted.selection, selection_of<Image>(asked));
    EXPECT_EQ(gated->destinations.size(), 2U);
  }
}

TEST_F(PartGroupsTest, AReaderThatAsksForAnotherPartLeavesItsGroupAtOnceAndJoinsTheNextOneWhenItHasSettled) {
  readers(3, "data[::3]");
  readers(2, "data[::4]");
  serve();
  go_on_with(100'000, 200ms);
  ASSERT_EQ(members(), 5U);
  routes_[0].selection = selection_of<Image>("data[::4]");
  serve();
  EXPECT_EQ(members(), 4U);
  EXPECT_EQ(sent_to(1), selection_of<Image>("data[::4]")) << "alone for now";
  go_on_with(100'000, 200ms);
  EXPECT_EQ(members(), 5U);
  EXPECT_EQ(sent_to(3), selection_of<Image>("data[::4]"));
}

/// A sample with a whole field names its fields. A sample with a part of a field names the requested
/// selection.
TEST_F(PartGroupsTest, OnlyCopiesOfWholeFieldsAreForWhoeverAskedForLess) {
  DestinationDirectory destinations{DestinationLimits{}, connections_.connect()};
  VariantDirectory variants{8, std::make_shared<WriterTally>()};
  const auto serve_by_table = [&] {
    return make_route_table(type_support<Image>(), routes_, variants, destinations, keeper_.get());
  };
  const auto table_for = [&](std::vector<const char*> asked) {
    restart(Multicast::automatic);
    routes_.clear();
    for (const char* one : asked) readers(1, one);
    for (core::Route& route : routes_) route.reliable = false;
    serve_by_table();
    now_ = std::chrono::steady_clock::now() + 1s;
    for (int i = 0; i < 1000; ++i) publish(10'000);
    EXPECT_TRUE(sft::test::eventually([&] {
      return keeper_->replan(std::chrono::steady_clock::now()) && serve_by_table()->audiences.size() == 1;
    }));
    return serve_by_table();
  };
  const auto same = table_for({"data[::3]", "data[::3]"});
  EXPECT_FALSE(same->audiences[0].merged);
  EXPECT_NE(same->audiences[0].multicast, nullptr);
  EXPECT_EQ(same->audiences[0].wire->mask, selection_of<Image>("data[::3]").hash());
  const auto other = table_for({"data[1:]", "data[2:]"});
  EXPECT_TRUE(other->audiences[0].merged);
  EXPECT_NE(other->audiences[0].multicast, nullptr);
  EXPECT_EQ(other->audiences[0].wire->mask, fields<Image>("data").hash());
}

}  // namespace
}  // namespace sft::udp::test
