// Samples outlive the ports and transports that delivered them. Ports are opened and closed while samples
// flow.
#include "tests/conformance/conformance.h"

namespace sft::conformance {
namespace {

using core::SampleHandle;
using core::SendStatus;

constexpr std::size_t sample_bytes = 3000;

TEST_P(Conformance, KeepsATakenSampleReadableWhateverBecomesOfItsPortsAndTransports) {
  Writer writer(stage);
  Reader reader(stage);
  writer.serve(reader);
  ASSERT_EQ(writer.publish(sample_bytes), SendStatus::sent);
  const SampleHandle sample = reader.next();
  ASSERT_TRUE(is_image(sample, sample_bytes));
  reader.destroy_port();
  EXPECT_TRUE(is_image(sample, sample_bytes));
  writer.destroy_port();
  EXPECT_TRUE(is_image(sample, sample_bytes));
  stage.here.reset();
  stage.there.reset();
  EXPECT_TRUE(is_image(sample, sample_bytes));
}

TEST_P(Conformance, WritesNothingIntoASampleThatIsStillHeld) {
  Writer writer(stage);
  Reader reader(stage);
  writer.serve(reader);
  std::vector<SampleHandle> sent, taken;
  for (int i = 0; i < 100; ++i) {
    sent.push_back(writer.make(sample_bytes));
    ASSERT_TRUE(sent.back());
    ASSERT_EQ(writer.port().send(sent.back()), SendStatus::sent);
    taken.push_back(reader.next());
  }
  sent.erase(sent.begin(), sent.begin() + 50);
  for (int i = 0; i < 50; ++i) ASSERT_EQ(writer.publish(10), SendStatus::sent);
  for (const SampleHandle& sample : sent) EXPECT_TRUE(is_image(sample, sample_bytes));
  for (const SampleHandle& sample : taken) EXPECT_TRUE(is_image(sample, sample_bytes));
}

TEST_P(Conformance, TakesAnUnsentSampleBackAfterItsPortWent) {
  Writer writer(stage);
  SampleHandle unsent = writer.make(sample_bytes);
  ASSERT_TRUE(unsent);
  writer.destroy_port();
  stage.there.reset();
  EXPECT_TRUE(is_image(unsent, sample_bytes));
  unsent.reset();
}

TEST_P(Conformance, DeliversWhatWasSentBeforeTheWriterWent) {
  Writer writer(stage);
  Reader reader(stage);
  writer.serve(reader);
  for (int i = 0; i < 3; ++i) ASSERT_EQ(writer.publish(sample_bytes), SendStatus::sent);
  writer.destroy_port();
  EXPECT_EQ(reader.next_sequences(3), numbers(1, 3));
}

TEST_P(Conformance, LetsAReaderGoWhileSamplesComeForIt) {
  Flood flood(stage, {}, 20);
  for (int i = 0; i < 20; ++i) {
    Reader reader(stage, {.depth = 2});
    reader.hear(flood.writer());
    flood.serve({reader.route()});
    ASSERT_TRUE(reader.next()) << i;
  }
}

TEST_P(Conformance, ReleasesSamplesOnAnyThreadAlsoAfterTheirReaderWent) {
  Writer writer(stage);
  auto reader = std::make_unique<Reader>(stage);
  writer.serve(*reader);
  std::vector<SampleHandle> held;
  for (int i = 0; i < 60; ++i) {
    ASSERT_EQ(writer.publish(sample_bytes), SendStatus::sent);
    held.push_back(reader->next());
  }
  std::jthread early([first = std::vector(held.begin(), held.begin() + 30)]() mutable { first.clear(); });
  reader.reset();
  std::jthread late([all = std::move(held)]() mutable {
    for (SampleHandle& sample : all) {
      EXPECT_TRUE(is_image(sample, sample_bytes));
      sample.reset();
    }
  });
}

TEST_P(Conformance, LetsPortsOutliveTheirTransport) {
  Writer writer(stage);
  Reader reader(stage);
  writer.serve(reader);
  writer.publish_to(reader, sample_bytes);
  stage.there.reset();
  stage.here.reset();
  EXPECT_NE(writer.publish(sample_bytes), SendStatus::dropped) << "sent, or the port is lost";
  if (const SampleHandle sample = reader.take()) {
    EXPECT_TRUE(is_image(sample, sample_bytes));
  }
}

TEST_P(Conformance, ClosesWhileSamplesFlow) {
  Reader reader(stage);
  Flood flood(stage, {reader.route()}, sample_bytes);
  reader.hear(flood.writer());
  const SampleHandle sample = reader.next();
  ASSERT_TRUE(sample);
  stage.there.reset();
  stage.here.reset();
  EXPECT_TRUE(is_image(sample, sample_bytes));
}

}  // namespace
}  // namespace sft::conformance
