// A writer that may wait for its reliable readers, on any medium. While the writer waits, these readers lose
// nothing. The writer waits for no other readers, and no longer than its limit. If the writer does not wait,
// each reader knows which samples it lost.
#include <utility>

#include "tests/conformance/conformance.h"

namespace sft::conformance {
namespace {

using core::SampleHandle;
using core::SendStatus;
using namespace std::chrono_literals;

constexpr std::uint32_t bounded_depth = 8;
/// More samples than any medium buffers (udp::ResendLimits: 4096).
constexpr std::uint64_t burst_samples = 6'000;
constexpr std::chrono::seconds for_good{60};

/// Publishes `samples` samples on a thread of its own.
class Publishing {
 public:
  Publishing(Writer& writer, std::uint64_t samples)
      : thread_([this, &writer, samples] {
          for (std::uint64_t n = 0; n < samples; ++n, ++published_) writer.publish();
        }) {}
  std::uint64_t published() const { return published_; }

 private:
  std::atomic<std::uint64_t> published_{0};
  std::jthread thread_;
};

/// The number of samples that a reader took, and the number of samples that are missing between them.
struct Taken {
  std::uint64_t last = 0, count = 0, missed = 0;
  bool in_order = true;
  void enter(const SampleHandle& sample) {
    in_order = in_order && sample->sequence > last;
    missed += last == 0 ? 0 : sample->sequence - last - 1;
    last = sample->sequence;
    ++count;
  }
  void take_until(Reader& reader, std::uint64_t end) {
    while (last < end) {
      const SampleHandle sample = reader.next();
      ASSERT_TRUE(sample) << "nothing comes behind " << last;
      enter(sample);
    }
  }
};

TEST_P(BackPressure, LosesNothingOfABurstThatIsLargerThanAnyQueue) {
  Writer writer(stage, 1, for_good);
  Reader reader(stage, {.depth = bounded_depth});
  writer.serve(reader);
  const Publishing publishing(writer, burst_samples);
  EXPECT_EQ(reader.next_sequences(burst_samples), numbers(1, burst_samples));
  EXPECT_EQ(reader.discarded(), 0U);
}

TEST_P(BackPressure, LosesNothingForAReaderThatStallsWhileItIsWaitedFor) {
  Writer writer(stage, 1, for_good);
  Reader reader(stage, {.depth = bounded_depth});
  writer.serve(reader);
  const Publishing publishing(writer, burst_samples);
  std::uint64_t before = 0;
  const auto waits = [&] {
    const std::uint64_t published = publishing.published();
    return std::exchange(before, published) == published && published >= bounded_depth;
  };
  ASSERT_TRUE(eventually(waits, hang_timeout, 100ms));
  EXPECT_LT(before, burst_samples) << "there is no room for more";
  EXPECT_EQ(reader.next_sequences(burst_samples), numbers(1, burst_samples));
  EXPECT_EQ(reader.discarded(), 0U);
}

TEST_P(BackPressure, WaitsForTheSlowerOfTwoReadersAndLosesNeitherOfThemAnything) {
  constexpr std::uint64_t samples = 1000;
  Writer writer(stage, 1, for_good);
  Reader slow(stage, {.depth = bounded_depth}), fast(stage, {.depth = bounded_depth});
  slow.hear(writer);
  fast.hear(writer);
  writer.serve({slow.route(), fast.route()});
  const Publishing publishing(writer, samples);
  std::atomic<std::uint64_t> taken_by_fast{0};
  std::jthread taking([&] {
    for (std::uint64_t n = 1; n <= samples; ++n) {
      EXPECT_EQ(fast.next_sequences(1), numbers(n, n));
      taken_by_fast = n;
    }
  });
  for (std::uint64_t n = 1; n <= samples; ++n) {
    ASSERT_TRUE(eventually([&] { return taken_by_fast >= n; }, hang_timeout, {}))
        << "the fast reader waits for more than it has to";
    ASSERT_EQ(slow.next_sequences(1), numbers(n, n));
  }
}

TEST_P(BackPressure, WaitsForNoBestEffortReader) {
  Writer writer(stage, 1, for_good);
  Reader careful(stage, {.depth = bounded_depth}),
      careless(stage, {.depth = bounded_depth, .best_effort = true});
  careful.hear(writer);
  careless.hear(writer);
  writer.serve({careful.route(), careless.route()});
  const auto begin = std::chrono::steady_clock::now();
  const Publishing publishing(writer, burst_samples);
  EXPECT_EQ(careful.next_sequences(burst_samples), numbers(1, burst_samples));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, for_good);
}

TEST_P(BackPressure, DropsSamplesForAReaderThatTakesNothingOnceItHasWaitedLongEnough) {
  Writer writer(stage, 1, 100us);
  Reader reader(stage, {.depth = bounded_depth});
  writer.serve(reader);
  Taken taken;
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  taken.take_until(reader, 1);
  std::uint64_t reported = 0;
  for (std::uint64_t n = 1; n < burst_samples; ++n) reported += writer.publish() == SendStatus::sent ? 0 : 1;
  taken.take_until(reader, burst_samples);
  EXPECT_TRUE(taken.in_order);
  EXPECT_GT(taken.missed, 0U);
  EXPECT_EQ(taken.count + taken.missed, burst_samples) << "each sample is taken or seen as a gap";
  EXPECT_GT(reported, 0U) << "the publisher knows that it did not wait long enough";
}

TEST_P(BackPressure, LosesNoMoreThanAReaderKnowsOfWhereItMayNotWait) {
  Writer writer(stage);
  Reader reader(stage, {.depth = bounded_depth});
  writer.serve(reader);
  Taken taken;
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  taken.take_until(reader, 1);
  for (std::uint64_t n = 1; n < burst_samples; ++n) writer.publish();
  taken.take_until(reader, burst_samples);
  EXPECT_TRUE(taken.in_order);
  EXPECT_GT(taken.missed, 0U);
  EXPECT_EQ(taken.count + taken.missed, burst_samples) << "each sample is taken or seen as a gap";
}

TEST_P(BackPressure, EndsWithTheReaderThatIsWaitedFor) {
  Writer writer(stage, 1, for_good);
  Reader reader(stage, {.depth = bounded_depth});
  writer.serve(reader);
  const auto begin = std::chrono::steady_clock::now();
  const Publishing publishing(writer, burst_samples);
  ASSERT_TRUE(eventually([&] { return publishing.published() >= bounded_depth; }, hang_timeout));
  reader.destroy_port();
  writer.serve(std::vector<core::Route>{});
  ASSERT_TRUE(eventually([&] { return publishing.published() == burst_samples; }, hang_timeout));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, for_good);
}

}  // namespace
}  // namespace sft::conformance
