// Samples of one writer arrive in the order in which they were sent, and each arrives once.
#include <map>

#include "tests/conformance/conformance.h"

namespace sft::conformance {
namespace {

using core::SampleHandle;
using core::SendStatus;

TEST_P(Conformance, CarriesWhatTheWriterWroteAndSaysWhoseItIs) {
  Writer writer(stage);
  Reader reader(stage);
  writer.serve(reader);
  ASSERT_EQ(writer.publish(1000), SendStatus::sent);
  const SampleHandle sample = reader.next();
  ASSERT_TRUE(is_image(sample, 1000));
  EXPECT_EQ(sample->writer, writer.id());
  EXPECT_EQ(sample->sequence, 1U);
  EXPECT_EQ(sample->source_stamp_ns, 1001);
  EXPECT_GT(sample->receive_stamp_ns, 0);
  EXPECT_EQ(sample->addressee, 0U);
  EXPECT_FALSE(reader.take()) << "it came twice";
}

TEST_P(Conformance, KeepsTheOrderOfLargeAndSmallSamplesOfEachWriter) {
  constexpr std::size_t sizes[]{60'000, 10, 1000};
  constexpr std::size_t rounds = 30;
  Writer first(stage, 1), second(stage, 2), third(stage, 3);
  Reader reader(stage);
  for (Writer* writer : {&first, &second, &third}) writer->serve(reader);
  std::map<core::EndpointId, std::vector<std::uint64_t>> came;
  for (std::size_t round = 0; round < rounds; ++round) {
    for (const std::size_t size : sizes) {
      for (Writer* writer : {&first, &second, &third}) ASSERT_EQ(writer->publish(size), SendStatus::sent);
    }
    for (int i = 0; i < 9; ++i) {
      const SampleHandle sample = reader.next();
      ASSERT_TRUE(sample) << round;
      ASSERT_TRUE(is_image(sample, sizes[(sample->sequence - 1) % 3]));
      came[sample->writer].push_back(sample->sequence);
    }
  }
  for (const core::EndpointId writer : {1U, 2U, 3U}) EXPECT_EQ(came[writer], numbers(1, 3 * rounds));
}

TEST_P(Conformance, DeliversToEachReaderWhatItSendsToAll) {
  Writer writer(stage);
  Reader one(stage), other(stage);
  one.hear(writer);
  other.hear(writer);
  writer.serve({one.route(), other.route()});
  for (int i = 0; i < 100; ++i) ASSERT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(one.next_sequences(100), numbers(1, 100));
  EXPECT_EQ(other.next_sequences(100), numbers(1, 100));
}

TEST_P(Conformance, LosesNothingFromTheMomentItIsConnectedAndServed) {
  Writer writer(stage);
  for (int round = 0; round < 30; ++round) {
    Reader reader(stage);
    writer.serve(reader);
    ASSERT_EQ(writer.publish(), SendStatus::sent);
    ASSERT_EQ(reader.next_sequences(1), std::vector{writer.sequence()}) << round;
  }
}

TEST_P(Conformance, IsConnectedToThoseWritersOnlyThatItWasConnectedTo) {
  Writer writer(stage, 1), other(stage, 2);
  Reader reader(stage);
  EXPECT_FALSE(reader.port().connected(1));
  writer.serve(reader);
  other.serve({reader.route()});
  EXPECT_FALSE(reader.port().connected(2));
  ASSERT_EQ(other.publish(), SendStatus::sent);
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  const SampleHandle sample = reader.next();
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->writer, 1U);
  EXPECT_FALSE(reader.take());
}

TEST_P(Conformance, SendsNothingWithoutRoutes) {
  Writer writer(stage);
  Reader reader(stage);
  reader.hear(writer);
  EXPECT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(writer.bytes_sent(), 0U);
  writer.serve({reader.route()});
  EXPECT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(reader.next_sequences(1), numbers(2, 2));
}

TEST_P(Conformance, DeliversWhatArrivedBeforeDisconnectingAndNothingFromThenUntilItConnectsAgain) {
  Writer writer(stage);
  Reader reader(stage), witness(stage);
  reader.hear(writer);
  witness.hear(writer);
  writer.serve({reader.route(), witness.route()});
  for (int i = 0; i < 2; ++i) writer.publish_to(reader);
  reader.port().disconnect(writer.id());
  EXPECT_FALSE(reader.port().connected(writer.id()));
  EXPECT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(witness.next_sequences(3), numbers(1, 3)) << "the last one is no longer under way";
  EXPECT_EQ(reader.take_sequences(), numbers(1, 2));
  reader.hear(writer);
  EXPECT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(reader.next_sequences(1), numbers(4, 4));
}

}  // namespace
}  // namespace sft::conformance
