// A late reader gets the retained samples, then the samples that were published meanwhile, then live
// samples, without gap or repetition. Other readers are not affected.
#include "tests/conformance/conformance.h"

namespace sft::conformance {
namespace {

using core::HistoryProgress;
using core::SampleHandle;
using core::SendStatus;

constexpr std::uint32_t history_depth = 3;

/// Returns the route of a reader that gets the retained samples first.
core::Route late(const Reader& reader) {
  core::Route route = reader.route();
  route.history = history_depth;
  return route;
}

void hear_late(Reader& reader, const Writer& writer) {
  core::Source source = reader.source(writer);
  source.history_first = true;
  ASSERT_TRUE(reader.port().connect(source));
  ASSERT_TRUE(eventually([&] { return reader.port().connected(writer.id()); }, hang_timeout));
}

std::vector<SampleHandle> retain(Writer& writer, std::size_t data_bytes) {
  std::vector<SampleHandle> retained;
  for (std::uint32_t i = 0; i < history_depth; ++i) retained.push_back(writer.make(data_bytes));
  return retained;
}

TEST_P(LateReaders, GetWhatWasRetainedBeforeWhatCameMeanwhile) {
  Writer writer(stage);
  Reader early(stage), latecomer(stage);
  early.hear(writer);
  hear_late(latecomer, writer);
  const std::vector<SampleHandle> retained = retain(writer, 30'000);
  writer.serve({early.route(), late(latecomer)});
  for (int i = 0; i < 2; ++i) ASSERT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(early.next_sequences(2), numbers(4, 5)) << "it waits for nobody";
  EXPECT_EQ(latecomer.port().history(writer.id()), HistoryProgress::awaited) << "it was not for it";
  writer.network_port().send_history(late(latecomer), retained);
  for (std::uint64_t n = 1; n <= 5; ++n) {
    const SampleHandle sample = latecomer.next();
    ASSERT_TRUE(is_image(sample, n <= history_depth ? 30'000 : 50));
    EXPECT_EQ(sample->sequence, n);
    EXPECT_EQ(sample->addressee, latecomer.route().reader);
    EXPECT_EQ(sample->oldest_retained, 1U);
  }
  EXPECT_NE(latecomer.port().history(writer.id()), HistoryProgress::awaited);
  EXPECT_FALSE(early.take());
}

TEST_P(LateReaders, AreServedAsAllOthersOnceTheirHistoryHasLeft) {
  Writer writer(stage);
  Reader early(stage), latecomer(stage);
  early.hear(writer);
  hear_late(latecomer, writer);
  writer.serve({early.route(), late(latecomer)});
  writer.network_port().send_history(late(latecomer), retain(writer, 10));
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  ASSERT_TRUE(
      eventually([&] { return writer.network_port().history_sent(latecomer.route().reader); }, hang_timeout));
  writer.serve({early.route(), latecomer.route()});
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(latecomer.next_sequences(5), numbers(1, 5));
  EXPECT_EQ(early.next_sequences(2), numbers(4, 5));
}

TEST_P(LateReaders, GetTheirHistoryOnce) {
  Writer writer(stage);
  Reader latecomer(stage);
  hear_late(latecomer, writer);
  const std::vector<SampleHandle> retained = retain(writer, 10);
  writer.serve({late(latecomer)});
  for (int i = 0; i < 2; ++i) writer.network_port().send_history(late(latecomer), retained);
  writer.serve({late(latecomer)});
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(latecomer.next_sequences(4), numbers(1, 4));
  EXPECT_FALSE(latecomer.take());
}

TEST_P(LateReaders, AreServedAlsoWhereNothingWasRetained) {
  Writer writer(stage);
  Reader latecomer(stage);
  hear_late(latecomer, writer);
  writer.serve({late(latecomer)});
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  writer.network_port().send_history(late(latecomer), {});
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(latecomer.next_sequences(2), numbers(1, 2));
}

}  // namespace
}  // namespace sft::conformance
