#include "udp_transport/receive/inbox.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "core/seam/buffer_pool.h"

namespace sft::udp {
namespace {

class InboxTest : public testing::Test {
 protected:
  using Taken = std::vector<std::pair<core::EndpointId, std::uint64_t>>;  ///< pairs of writer and sequence

  void deliver(core::EndpointId writer, std::uint64_t from, std::uint64_t to,
               std::uint64_t oldest_retained = 0, std::uint32_t numbering = 0) {
    for (std::uint64_t sequence = from; sequence <= to; ++sequence) {
      core::SampleHandle sample = memory_->take(1000);
      ASSERT_TRUE(sample);
      sample->header().writer = writer;
      sample->header().sequence = sequence;
      sample->oldest_retained = oldest_retained;
      sample->numbering = numbering;
      sample->addressee = oldest_retained == 0 ? 0 : 1;
      inbox_.deliver(std::move(sample));
    }
  }
  /// Returns how many further samples of the writer can wait.
  std::size_t room(core::EndpointId writer) const {
    KeepLastQueue::Room room = inbox_.room(writer);
    std::size_t samples = 0;
    while (room.take(1000)) ++samples;
    return samples;
  }
  Taken take_all() {
    Taken taken;
    while (const core::SampleHandle sample = inbox_.take())
      taken.emplace_back(sample->header().writer, sample->header().sequence);
    return taken;
  }

  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(20 * (1024 + 128));
  Inbox inbox_{3, nullptr};
};

TEST_F(InboxTest, GivesWhatAWriterSentBeforeItWent) {
  inbox_.connect({1});
  deliver(1, 1, 2);
  inbox_.disconnect(1);
  deliver(1, 3, 3);
  EXPECT_EQ(take_all(), (Taken{{1, 1}, {1, 2}}));
  EXPECT_EQ(inbox_.lost_unnoticed(), 0U);
}

TEST_F(InboxTest, KeepsNoMoreOfAllWritersThatWentThanOfOne) {
  for (core::EndpointId writer = 1; writer <= 1000; ++writer) {
    inbox_.connect({writer});
    deliver(writer, 1, 2);
    inbox_.disconnect(writer);
  }
  EXPECT_EQ(take_all(), (Taken{{999, 2}, {1000, 1}, {1000, 2}}));
  EXPECT_EQ(inbox_.discarded(), 1997U);
}

TEST_F(InboxTest, KeepsNoMoreBytesOfAllWritersThatWentThanOfOne) {
  Inbox inbox(100, nullptr, 2500);
  const auto leaves = [&](core::EndpointId writer, std::uint32_t bytes) {
    inbox.connect({writer});
    core::SampleHandle sample = memory_->take(1000);
    sample->header().writer = writer;
    sample->header().sequence = writer;
    sample->header().body_bytes = bytes;
    inbox.deliver(std::move(sample));
    inbox.disconnect(writer);
  };
  for (core::EndpointId writer = 1; writer <= 10; ++writer) leaves(writer, 1000);
  EXPECT_EQ(inbox.discarded(), 8U);
  leaves(11, 9000);
  EXPECT_EQ(inbox.discarded(), 10U);
  EXPECT_EQ(inbox.take()->header().sequence, 11U) << "one of any size";
  EXPECT_FALSE(inbox.take());
}

TEST_F(InboxTest, LeavesTheQueuesOfConnectedWritersAlone) {
  inbox_.connect({1});
  inbox_.connect({2});
  deliver(1, 1, 3);
  for (core::EndpointId writer = 3; writer <= 10; ++writer) {
    inbox_.connect({writer});
    deliver(writer, 1, 3);
    inbox_.disconnect(writer);
  }
  EXPECT_EQ(take_all(), (Taken{{1, 1}, {1, 2}, {1, 3}, {10, 1}, {10, 2}, {10, 3}}));
}

TEST_F(InboxTest, TellsHowManyMoreSamplesOfAWriterCanWait) {
  inbox_.connect({.writer = 7});
  inbox_.connect({.writer = 8});
  EXPECT_EQ(room(7), 3U);
  deliver(7, 1, 2);
  EXPECT_EQ(room(7), 1U);
  EXPECT_EQ(room(8), 3U);
  deliver(7, 3, 5);
  EXPECT_EQ(room(7), 0U);
  take_all();
  EXPECT_EQ(room(7), 3U);
}

/// A subscriber counts the gaps in a writer's sequences. Gaps do not show losses after the last sample or
/// before the first sample.
TEST_F(InboxTest, CountsLossesThatNoSequenceShows) {
  inbox_.connect({1});
  deliver(1, 1, 3);
  EXPECT_EQ(inbox_.take()->header().sequence, 1U);
  inbox_.connect({2});
  deliver(2, 1, 3);
  inbox_.disconnect(1);
  inbox_.disconnect(2);  // 5 samples wait: 2 and 3 of the first writer are dropped
  EXPECT_EQ(inbox_.lost_unnoticed(), 2U);

  inbox_.connect({3});
  deliver(3, 1, 1);
  inbox_.disconnect(3);  // sample 1 of the second writer is dropped, before a sample of that writer was taken
  EXPECT_EQ(take_all(), (Taken{{2, 2}, {2, 3}, {3, 1}}));
  EXPECT_EQ(inbox_.lost_unnoticed(), 3U);
}

TEST_F(InboxTest, CountsWhatWasPushedOutBeforeTheFirstSampleWasTaken) {
  inbox_.connect({1});
  deliver(1, 1, 5);
  EXPECT_EQ(take_all(), (Taken{{1, 3}, {1, 4}, {1, 5}}));
  EXPECT_EQ(inbox_.lost_unnoticed(), 2U);
  deliver(1, 6, 10);
  EXPECT_EQ(take_all(), (Taken{{1, 8}, {1, 9}, {1, 10}}));
  EXPECT_EQ(inbox_.lost_unnoticed(), 2U) << "a gap tells of 6 and 7";
}

TEST_F(InboxTest, CountsEachSampleThatItThrowsAwayOnceAndNoOther) {
  constexpr std::uint32_t anew = 1;
  inbox_.connect({1});
  const auto expect_discarded = [&](std::uint64_t count, const char* which) {
    EXPECT_EQ(inbox_.discarded(), count) << which;
  };
  deliver(1, 2, 4);
  expect_discarded(0, "there is room");
  deliver(1, 5, 6);
  expect_discarded(2, "2 and 3 are pushed out");
  deliver(1, 5, 5);
  deliver(9, 1, 1);
  expect_discarded(2, "one is repeated, and one is from a writer that is not connected");
  deliver(1, 1, 1);
  expect_discarded(3, "it comes too late");
  EXPECT_EQ(take_all().size(), 3U);
  deliver(1, 7, 8);
  deliver(1, 7, 7, 0, anew);
  expect_discarded(5, "7 and 8 had wrong numbers");
  EXPECT_EQ(take_all(), (Taken{{1, 7}}));
  inbox_.connect({2});
  deliver(2, 7, 8);
  deliver(2, 1, 1, 0, anew);
  expect_discarded(7, "7 and 8 of the second writer had wrong numbers, too");
  EXPECT_EQ(take_all(), (Taken{{2, 1}}));
  EXPECT_EQ(inbox_.lost_unnoticed(), 2U + 2U) << "no gap shows the first samples of either writer";
}

TEST_F(InboxTest, ForgetsAWriterThatWentOnceNothingOfItIsLeft) {
  inbox_.connect({1});
  deliver(1, 1, 1);
  take_all();
  EXPECT_EQ(inbox_.arrivals(1), 1U);
  inbox_.disconnect(1);
  EXPECT_EQ(inbox_.arrivals(1), 0U) << "all was taken before";
  inbox_.connect({2});
  deliver(2, 1, 2);
  inbox_.disconnect(2);
  EXPECT_EQ(inbox_.arrivals(2), 2U);
  take_all();
  EXPECT_EQ(inbox_.arrivals(2), 0U) << "all was taken afterwards";
  inbox_.connect({3});
  deliver(3, 1, 1);
  inbox_.disconnect(3);
  inbox_.connect({4});
  deliver(4, 1, 3);
  inbox_.disconnect(4);
  EXPECT_EQ(inbox_.arrivals(3), 0U) << "the sample that was left gave way";
}

TEST_F(InboxTest, CountsWhatWasPushedOutBeforeAllThatWasLeftBehind) {
  inbox_.connect({1});
  deliver(1, 1, 1);
  EXPECT_EQ(take_all(), (Taken{{1, 1}}));
  deliver(1, 2, 6);  // samples 2 and 3 are dropped
  inbox_.disconnect(1);
  inbox_.connect({2});
  deliver(2, 1, 3);
  inbox_.disconnect(2);  // the remaining samples of the first writer are dropped
  EXPECT_EQ(take_all(), (Taken{{2, 1}, {2, 2}, {2, 3}}));
  EXPECT_EQ(inbox_.lost_unnoticed(), 5U);
}

TEST_F(InboxTest, CountsWhatWasPushedOutBeforeTheFirstSampleNoSecondTimeWhenTheWriterGoes) {
  inbox_.connect({1});
  deliver(1, 1, 5);  // 1 and 2 are dropped
  EXPECT_EQ(inbox_.take()->header().sequence, 3U);
  EXPECT_EQ(inbox_.lost_unnoticed(), 2U);
  inbox_.disconnect(1);
  inbox_.connect({2});
  deliver(2, 1, 3);
  inbox_.disconnect(2);  // 4 and 5 of the first writer are dropped
  EXPECT_EQ(take_all(), (Taken{{2, 1}, {2, 2}, {2, 3}}));
  EXPECT_EQ(inbox_.lost_unnoticed(), 4U);
}

TEST_F(InboxTest, LeavesLossesThatASequenceShowsToIt) {
  inbox_.connect({1});
  deliver(1, 1, 3);
  EXPECT_EQ(inbox_.take()->header().sequence, 1U);
  inbox_.connect({2});
  deliver(2, 1, 2);
  inbox_.disconnect(1);
  inbox_.disconnect(2);  // 4 samples wait: 2 of the first writer is dropped
  EXPECT_EQ(take_all(), (Taken{{1, 3}, {2, 1}, {2, 2}}));
  EXPECT_EQ(inbox_.lost_unnoticed(), 0U);
}

/// Each sample of a writer's history carries the sequence of the first sample that was sent.
TEST_F(InboxTest, LeavesLossesOfRetainedSamplesToTheirReader) {
  inbox_.connect({1});
  deliver(1, 11, 13, 11);
  inbox_.connect({2});
  deliver(2, 1, 1);
  inbox_.disconnect(1);
  inbox_.disconnect(2);  // 4 samples wait: 11 of the first writer is dropped
  EXPECT_EQ(take_all(), (Taken{{1, 12}, {1, 13}, {2, 1}}));
  EXPECT_EQ(inbox_.lost_unnoticed(), 0U);
}

TEST_F(InboxTest, TakesNothingOfADurableWriterUntilSomethingForItsReaderAloneCame) {
  inbox_.connect({.writer = 1, .history_first = true});
  deliver(1, 5, 6);
  EXPECT_EQ(inbox_.history(1), core::HistoryProgress::awaited);
  deliver(1, 4, 5, 4);
  EXPECT_NE(inbox_.history(1), core::HistoryProgress::awaited);
  deliver(1, 6, 6);
  EXPECT_EQ(take_all(), (Taken{{1, 4}, {1, 5}, {1, 6}}));
  EXPECT_EQ(inbox_.discarded(), 0U);
  inbox_.disconnect(1);
  inbox_.connect({.writer = 1, .history_first = true});
  EXPECT_EQ(inbox_.history(1), core::HistoryProgress::awaited) << "it may have forgotten us";
}

}  // namespace
}  // namespace sft::udp
