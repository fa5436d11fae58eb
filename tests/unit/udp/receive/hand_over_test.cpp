#include "udp_transport/receive/hand_over.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "core/seam/buffer_pool.h"

namespace sft::udp {
namespace {

class HandOverTest : public testing::Test {
 protected:
  using Sequences = std::vector<std::uint64_t>;
  static constexpr core::EndpointId writer = 7, other = 8;

  void add(std::uint64_t sequence, bool overtakes, core::EndpointId of = writer) {
    core::SampleHandle sample = pool_->take(100);
    sample->header().writer = of;
    sample->header().sequence = sequence;
    hand_over_.add({std::move(sample), false, overtakes});
  }
  Sequences next(core::EndpointId of = writer) {
    Sequences sequences;
    for (HandOver::Waiting one = hand_over_.next(of); one.sample; one = hand_over_.next(of))
      sequences.push_back(one.sample->header().sequence);
    return sequences;
  }
  Sequences rest() {
    Sequences sequences;
    for (HandOver::Waiting one = hand_over_.next(); one.sample; one = hand_over_.next())
      sequences.push_back(one.sample->header().sequence);
    return sequences;
  }

  std::shared_ptr<core::BufferPool> pool_ = core::BufferPool::make(1 << 20);
  HandOver hand_over_;
};

TEST_F(HandOverTest, LetsASampleWaitUntilTheOneBeforeItHasCome) {
  add(12, true);
  EXPECT_EQ(next(), Sequences{});
  add(10, false);
  EXPECT_EQ(next(), Sequences{10});
  add(11, false);
  EXPECT_EQ(next(), (Sequences{11, 12}));
  EXPECT_FALSE(hand_over_.is_under_way());
}

TEST_F(HandOverTest, LetsWhatComesBehindASampleThatWaitsWaitToo) {
  add(12, true);
  add(13, false);
  add(12, false);  // The same sample, sent under another mask.
  EXPECT_EQ(next(), Sequences{});
  add(11, false);
  EXPECT_EQ(next(), (Sequences{11, 12, 12, 13}));
}

TEST_F(HandOverTest, GivesInOrderWhatNothingMoreCanComeBefore) {
  add(14, true);
  add(12, true);
  EXPECT_EQ(next(), Sequences{});
  EXPECT_EQ(rest(), (Sequences{12, 14}));
  EXPECT_FALSE(hand_over_.is_under_way());
}

TEST_F(HandOverTest, IsNothingToOtherWriters) {
  add(12, true);
  EXPECT_TRUE(hand_over_.concerns(writer));
  EXPECT_FALSE(hand_over_.concerns(other));
  add(11, false, other);
  EXPECT_EQ(next(other), Sequences{11});
  EXPECT_EQ(next(), Sequences{}) << "the sample before it was another writer's";
  EXPECT_EQ(rest(), Sequences{12});
}

TEST_F(HandOverTest, IsFullBeforeItTakesMuchMemory) {
  for (std::uint64_t sequence = 2; !hand_over_.is_full(); ++sequence) {
    ASSERT_LT(sequence, 1000U);
    add(sequence, true);
  }
}

}  // namespace
}  // namespace sft::udp
