// A reader knows exactly which samples it missed. Each sample that arrived is taken, or it counts as
// discarded. A discarded sample leaves a gap in the sequences, or counts as lost without a gap.
#include "tests/conformance/conformance.h"
#include "tests/support/test_seed.h"

namespace sft::conformance {
namespace {

using core::SampleHandle;
using core::SendStatus;

/// Counts the taken samples and the missing samples of one writer, as a subscriber does.
class Account {
 public:
  void enter(const SampleHandle& sample) {
    EXPECT_GT(sample->sequence, last_);
    missed_ += last_ == 0 ? 0 : sample->sequence - last_ - 1;
    last_ = sample->sequence;
    ++taken_;
  }
  std::uint64_t last() const { return last_; }
  std::uint64_t taken() const { return taken_; }
  /// The number of samples that are missing between samples that were taken.
  std::uint64_t missed() const { return missed_; }

 private:
  std::uint64_t last_ = 0;
  std::uint64_t taken_ = 0;
  std::uint64_t missed_ = 0;
};

TEST_P(Conformance, KeepsTheNewestOfEachWriterForASlowReaderAndCountsTheRest) {
  Writer first(stage, 1), second(stage, 2);
  Reader reader(stage, {.depth = 3});
  first.serve(reader);
  second.serve(reader);
  first.publish_to(reader);
  EXPECT_EQ(reader.next_sequences(1), numbers(1, 1));
  for (int i = 0; i < 10; ++i) first.publish_to(reader);
  for (int i = 0; i < 2; ++i) second.publish_to(reader);
  std::vector<std::uint64_t> of_first, of_second;
  while (const SampleHandle sample = reader.take())
    (sample->writer == 1 ? of_first : of_second).push_back(sample->sequence);
  EXPECT_EQ(of_first, numbers(9, 11));
  EXPECT_EQ(of_second, numbers(1, 2)) << "a flood of one writer is nothing to another";
  EXPECT_EQ(reader.discarded(), 7U);
  EXPECT_EQ(reader.lost_unnoticed(), 0U) << "the gap tells";
}

TEST_P(Conformance, KeepsTheNewestOneAtADepthOfOne) {
  Writer writer(stage);
  Reader reader(stage, {.depth = 1});
  writer.serve(reader);
  for (int i = 0; i < 20; ++i) writer.publish_to(reader);
  EXPECT_EQ(reader.take_sequences(), numbers(20, 20));
}

TEST_P(Conformance, CountsWhatWasPushedOutBeforeTheFirstSampleWasTaken) {
  Writer writer(stage);
  Reader reader(stage, {.depth = 3});
  writer.serve(reader);
  for (int i = 0; i < 10; ++i) writer.publish_to(reader);
  EXPECT_EQ(reader.take_sequences(), numbers(8, 10));
  if (traits().counts_before_first_taken) {
    EXPECT_EQ(reader.discarded(), 7U);
    EXPECT_EQ(reader.lost_unnoticed(), 7U) << "no gap tells: nobody knew where its sequences began";
  } else {
    EXPECT_GE(reader.discarded(), 1U);
  }
}

TEST_P(Conformance, KnowsWhatAReaderMissedThatTakesNowAndThen) {
  test::Random random{test::test_seed()};
  SCOPED_TRACE(test::how_to_repeat());
  Writer writer(stage);
  Reader reader(stage, {.depth = 4});
  writer.serve(reader);
  writer.publish_to(reader);
  Account account;
  account.enter(reader.next());
  for (int burst = 0; burst < 200; ++burst) {
    for (auto samples = random() % 9; samples > 0; --samples) writer.publish_to(reader);
    for (auto takes = random() % 5; takes > 0; --takes) {
      if (const SampleHandle sample = reader.take()) account.enter(sample);
    }
  }
  while (const SampleHandle sample = reader.take()) account.enter(sample);
  EXPECT_EQ(account.last(), writer.sequence());
  EXPECT_EQ(account.taken() + account.missed(), writer.sequence());
  EXPECT_EQ(reader.discarded(), account.missed());
}

/// The writer waits after each burst until all samples have arrived, so that the transport loses none.
TEST_P(Conformance, KnowsWhatAReaderMissedThatTakesWhileSamplesCome) {
  constexpr std::uint64_t samples = 20'000, burst = 32;
  test::Random random{test::test_seed()};
  SCOPED_TRACE(test::how_to_repeat());
  Writer writer(stage);
  Reader reader(stage, {.depth = 2});
  writer.serve(reader);
  writer.publish_to(reader);
  Account account;
  account.enter(reader.next());
  std::atomic<std::uint64_t> newest{1};
  std::jthread publisher([&] {
    while (writer.sequence() < samples) {
      EXPECT_EQ(writer.publish(), SendStatus::sent);
      if (writer.sequence() % burst != 0) continue;
      EXPECT_TRUE(eventually([&] { return newest == writer.sequence(); }, hang_timeout, {}));
    }
  });
  while (account.last() < samples) {
    const SampleHandle sample = reader.next();
    ASSERT_TRUE(sample) << account.last();
    account.enter(sample);
    newest = account.last();
    for (auto spins = random() % 2000; spins > 0; --spins) asm volatile("");
  }
  publisher.join();
  EXPECT_EQ(account.taken() + account.missed(), samples);
  EXPECT_EQ(reader.discarded(), account.missed());
}

TEST_P(Conformance, KeepsOneDepthOfWhatDepartedWritersLeftAndCountsTheRest) {
  Reader reader(stage, {.depth = 3});
  for (core::EndpointId id = 1; id <= 6; ++id) {
    Writer writer(stage, id);
    writer.serve(reader);
    for (int i = 0; i < 2; ++i) writer.publish_to(reader);
    reader.port().disconnect(id);
  }
  EXPECT_EQ(reader.discarded(), 9U);
  std::vector<std::pair<core::EndpointId, std::uint64_t>> taken;
  while (const SampleHandle sample = reader.take()) taken.emplace_back(sample->writer, sample->sequence);
  EXPECT_EQ(taken, (decltype(taken){{5, 2}, {6, 1}, {6, 2}}));
  EXPECT_EQ(reader.lost_unnoticed(), 9U) << "nothing was taken before what is missing";
}

TEST_P(Conformance, CountsWhatADepartedWriterLeftThatNoGapShows) {
  Writer writer(stage, 1), next(stage, 2);
  Reader reader(stage, {.depth = 2});
  writer.serve(reader);
  for (int i = 0; i < 3; ++i) writer.publish_to(reader);
  EXPECT_EQ(reader.next_sequences(1), numbers(2, 2));
  next.serve(reader);
  for (int i = 0; i < 2; ++i) next.publish_to(reader);
  reader.port().disconnect(1);
  const std::uint64_t before = reader.lost_unnoticed();
  reader.port().disconnect(2);
  EXPECT_EQ(reader.lost_unnoticed(), before + 1) << "sample 3 of the first one";
  EXPECT_EQ(reader.take_sequences(), numbers(1, 2));
}

TEST_P(Conformance, LeavesOthersAloneWhereOneReaderIsSlow) {
  Writer writer(stage);
  Reader slow(stage, {.depth = 1}), fast(stage);
  slow.hear(writer);
  fast.hear(writer);
  writer.serve({slow.route(), fast.route()});
  for (std::uint64_t n = 1; n <= 200; ++n) {
    ASSERT_EQ(writer.publish(), SendStatus::sent);
    ASSERT_EQ(fast.next_sequences(1), numbers(n, n));
  }
  EXPECT_EQ(fast.discarded(), 0U);
  std::uint64_t newest = 0;
  while (newest < 200) {
    const SampleHandle sample = slow.next();
    ASSERT_TRUE(sample);
    newest = sample->sequence;
  }
}

}  // namespace
}  // namespace sft::conformance
