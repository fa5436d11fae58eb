// Each sample decodes under the mask that the sample names, even while routes change. If all readers share
// one sample, that mask is the full mask. Otherwise it is the mask that the reader requested.
#include "tests/conformance/conformance.h"

namespace sft::conformance {
namespace {

using namespace detail;

using core::SampleHandle;
using core::SendStatus;

const std::vector<std::string> masks{
    "*", "data", "stamp", "", "height, data", "name", "stamp.sec, width, name"};

TEST_P(Conformance, GivesEachReaderItsFields) {
  Writer writer(stage);
  std::vector<std::unique_ptr<Reader>> readers;
  std::vector<core::Route> routes;
  for (const std::string& mask : masks) {
    Reader& reader = *readers.emplace_back(std::make_unique<Reader>(stage, ReaderOptions{.masks = {mask}}));
    reader.hear(writer);
    routes.push_back(reader.route());
  }
  writer.serve(routes);
  for (const std::size_t bytes : {10U, 20'000U, 1000U}) {
    ASSERT_EQ(writer.publish(bytes), SendStatus::sent);
    for (std::size_t i = 0; i < masks.size(); ++i) {
      const SampleHandle sample = readers[i]->next();
      ASSERT_TRUE(is_image(sample, bytes)) << masks[i];
      const FieldMask asked = fields<Image>(masks[i]);
      EXPECT_TRUE(traits().projects ? sample->mask == asked : sample->mask.is_full()) << masks[i];
    }
  }
}

TEST_P(Conformance, GivesBodiesInWhichEachPrimitiveIsAligned) {
  test::Random random{test::test_seed()};
  Writer writer(stage);
  Reader reader(stage);
  writer.serve(reader);
  for (int i = 0; i < 100; ++i) {
    const std::size_t bytes = random() % 100'000;
    ASSERT_EQ(writer.publish(bytes), SendStatus::sent) << test::how_to_repeat();
    const SampleHandle sample = reader.next();
    ASSERT_TRUE(is_image(sample, bytes)) << test::how_to_repeat();
    const std::byte* const body = sample->data + sample->header().body_offset;
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(body) % sizeof(double), 0U) << test::how_to_repeat();
  }
}

TEST_P(Conformance, CarriesSamplesWithNoRequestedField) {
  Writer writer(stage);
  Reader reader(stage, {.masks = {""}});
  writer.serve(reader);
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  const SampleHandle sample = reader.next();
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->sequence, 1U);
  EXPECT_EQ(sample->source_stamp_ns, 1001);
  if (traits().projects) {
    EXPECT_EQ(sample->header().body_bytes, 0U);
  }
}

TEST_P(Conformance, DecodesEverySampleWhileRoutesChange) {
  constexpr std::size_t bytes = 40'000;
  Writer writer(stage);
  Reader reader(stage, {.masks = masks});
  writer.serve(reader);
  const std::jthread agent([&](const std::stop_token& stop) {
    for (std::size_t i = 0; !stop.stop_requested(); ++i)
      writer.serve({reader.route(masks[i % masks.size()])});
  });
  for (std::uint64_t n = 1; n <= 500; ++n) {
    ASSERT_EQ(writer.publish(bytes), SendStatus::sent);
    const SampleHandle sample = reader.next();
    ASSERT_TRUE(is_image(sample, bytes));
    EXPECT_EQ(sample->sequence, n) << "no route was ever missing";
  }
  EXPECT_EQ(stage.here->counters().malformed, 0U);
}

TEST_P(Conformance, LosesNothingForThoseThatStayWhileOthersComeAndGo) {
  Writer writer(stage);
  Reader stays(stage), comes_and_goes(stage, {.masks = {"stamp"}, .depth = 1});
  stays.hear(writer);
  comes_and_goes.hear(writer);
  writer.serve({stays.route()});
  const std::jthread agent([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      writer.serve({comes_and_goes.route(), stays.route()});
      writer.serve({stays.route()});
    }
  });
  for (std::uint64_t n = 1; n <= 500; ++n) {
    ASSERT_EQ(writer.publish(), SendStatus::sent);
    ASSERT_EQ(stays.next_sequences(1), numbers(n, n));
  }
}

TEST_P(Projection, KeepsSamplesFromAReaderThatAskedForOtherFields) {
  Writer writer(stage);
  Reader reader(stage, {.masks = {"stamp"}}), witness(stage, {.masks = {"data"}});
  reader.hear(writer);
  witness.hear(writer);
  writer.serve({reader.route("data"), witness.route()});
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(witness.next_sequences(1), numbers(1, 1));
  writer.serve({reader.route()});
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(reader.next_sequences(1), numbers(2, 2));
}

}  // namespace
}  // namespace sft::conformance
