// Sizes of samples, depths of queues and numbers of samples, at their limits and beyond.
#include "tests/conformance/conformance.h"

namespace sft::conformance {
namespace {

using core::SampleHandle;
using core::SendStatus;

/// The size in bytes of an encoded image without data. All other fields precede the data.
const std::size_t empty_image_bytes = encoded_body(make_image(0), fields<Image>("*")).size();

TEST_P(Conformance, CarriesSamplesOfEverySize) {
  Writer writer(stage);
  Reader reader(stage);
  writer.serve(reader);
  for (std::size_t bytes = 1; bytes <= stage.here->max_sample_bytes() / 4; bytes *= 4) {
    for (const std::size_t near : {bytes - 1, bytes, bytes + 1}) {
      ASSERT_EQ(writer.publish(near), SendStatus::sent) << near;
      ASSERT_TRUE(is_image(reader.next(), near)) << near;
    }
  }
}

/// Over UDP the sample may be lost if the kernel gives a socket little memory.
TEST_P(Conformance, CarriesTheLargestSample) {
  Writer writer(stage);
  Reader reader(stage);
  writer.serve(reader);
  const std::size_t bytes = stage.there->max_sample_bytes() - empty_image_bytes;
  SampleHandle sample;
  const auto arrives = [&] {
    EXPECT_EQ(writer.publish(bytes), SendStatus::sent);
    return eventually([&] { return static_cast<bool>(sample = reader.take()); }, std::chrono::seconds(3));
  };
  for (int attempt = 0; attempt < 10 && !arrives(); ++attempt) {
  }
  EXPECT_TRUE(is_image(sample, bytes));
}

TEST_P(Conformance, DropsWhatIsFarTooLargeCountsItAndGoesOn) {
  Writer writer(stage);
  Reader reader(stage);
  writer.serve(reader);
  EXPECT_EQ(writer.publish(2 * stage.there->max_sample_bytes()), SendStatus::dropped);
  EXPECT_EQ(stage.there->counters().over_limit, 1U);
  const std::uint64_t next = writer.sequence() + 1;
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(reader.next_sequences(1), numbers(next, next));
}

TEST_P(Conformance, TakesADepthOfZeroForOne) {
  Writer writer(stage);
  Reader reader(stage, {.depth = 0});
  writer.serve(reader);
  for (int i = 0; i < 3; ++i) writer.publish_to(reader);
  EXPECT_EQ(reader.take_sequences(), numbers(3, 3));
}

TEST_P(Conformance, KeepsAsManySamplesAsItsDepthSays) {
  constexpr std::uint32_t depth = 200;
  Writer writer(stage);
  Reader reader(stage, {.depth = depth});
  writer.serve(reader);
  for (std::uint32_t i = 0; i < depth; ++i) writer.publish_to(reader, 10);
  EXPECT_EQ(reader.take_sequences(), numbers(1, depth));
  EXPECT_EQ(reader.discarded(), 0U);
}

TEST_P(Conformance, ServesManyReadersOfOneWriter) {
  Writer writer(stage);
  std::vector<std::unique_ptr<Reader>> readers;
  std::vector<core::Route> routes;
  for (std::size_t i = 0; i < 50; ++i) {
    readers.push_back(std::make_unique<Reader>(stage));
    readers.back()->hear(writer);
    routes.push_back(readers.back()->route());
  }
  writer.serve(routes);
  for (int i = 0; i < 10; ++i) ASSERT_EQ(writer.publish(), SendStatus::sent);
  for (const auto& reader : readers) EXPECT_EQ(reader->next_sequences(10), numbers(1, 10));
}

TEST_P(Conformance, BringsManyWritersToOneReader) {
  constexpr std::size_t count = 50;
  Reader reader(stage);
  std::vector<std::unique_ptr<Writer>> writers;
  for (core::EndpointId id = 1; id <= count; ++id) {
    writers.push_back(std::make_unique<Writer>(stage, id));
    writers.back()->serve(reader);
  }
  std::vector<std::uint64_t> came(count + 1);
  for (std::uint64_t n = 1; n <= 5; ++n) {
    for (const auto& writer : writers) ASSERT_EQ(writer->publish(), SendStatus::sent);
    for (std::size_t i = 0; i < count; ++i) {
      const SampleHandle sample = reader.next();
      ASSERT_TRUE(sample) << n << ", " << i;
      ++came[sample->writer];
    }
    for (core::EndpointId id = 1; id <= count; ++id) EXPECT_EQ(came[id], n) << id;
  }
}

}  // namespace
}  // namespace sft::conformance
