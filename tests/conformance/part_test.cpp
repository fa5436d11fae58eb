// Over networks each reader gets the parts of fields that it requested, even while it changes its request.
// Readers that share the memory of a sample get the whole sample.
#include "core/seam/gate.h"
#include "tests/conformance/conformance.h"

namespace sft::conformance {
namespace {

using core::SampleHandle;
using core::SendStatus;

const std::vector<std::string> parts{"data[::3]",          "data",          "height, data[5:9], stamp",
                                     "data[100:]",         "name, data[0]", "stamp",
                                     "data[10:5000:2], *", "data[0:0]",     "data[::4]"};

TEST_P(Projection, GivesEachReaderItsPartsOfFields) {
  Writer writer(stage);
  std::vector<std::unique_ptr<Reader>> readers;
  std::vector<core::Route> routes;
  for (const std::string& text : parts) {
    Reader& reader = *readers.emplace_back(std::make_unique<Reader>(stage, ReaderOptions{.masks = {text}}));
    reader.hear(writer);
    routes.push_back(reader.route());
  }
  writer.serve(routes);
  for (const std::size_t bytes : {10U, 20'000U, 0U, 1000U, 300'000U}) {
    ASSERT_EQ(writer.publish(bytes), SendStatus::sent);
    for (std::size_t i = 0; i < parts.size(); ++i)
      ASSERT_TRUE(is_part(readers[i]->next(), bytes, selection(parts[i]))) << parts[i] << " of " << bytes;
  }
}

TEST_P(Projection, GivesASampleThePartsThatItNamesWhileReadersAskForOthers) {
  constexpr std::size_t bytes = 40'000;
  Writer writer(stage);
  Reader reader(stage, {.masks = parts});
  writer.serve(reader);
  std::vector<Selection> asked;
  for (const std::string& text : parts) asked.push_back(selection(text));
  const std::jthread agent([&](const std::stop_token& stop) {
    for (std::size_t i = 0; !stop.stop_requested(); ++i)
      writer.serve({reader.route(parts[i % parts.size()])});
  });
  for (std::uint64_t n = 1; n <= 1000; ++n) {
    ASSERT_EQ(writer.publish(bytes), SendStatus::sent);
    const SampleHandle sample = reader.next();
    ASSERT_TRUE(sample);
    EXPECT_EQ(sample->sequence, n) << "no route was ever missing";
    const auto named = std::ranges::find_if(asked, [&](const Selection& one) {
      return one.mask() == sample->mask && one.parts_hash() == sample->parts;
    });
    ASSERT_NE(named, asked.end());
    ASSERT_TRUE(is_part(sample, bytes, *named));
  }
  EXPECT_EQ(stage.here->counters().malformed, 0U);
}

TEST_P(Projection, KeepsSamplesFromAReaderThatAskedForAnotherPart) {
  Writer writer(stage);
  Reader reader(stage, {.masks = {"data[::2]"}}), witness(stage, {.masks = {"data[::3]"}});
  reader.hear(writer);
  witness.hear(writer);
  writer.serve({reader.route("data[::3]"), witness.route()});
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(witness.next_sequences(1), std::vector<std::uint64_t>{1});
  writer.serve({reader.route("data"), witness.route()});
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(witness.next_sequences(1), std::vector<std::uint64_t>{2});
  writer.serve({reader.route()});
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(reader.next_sequences(1), std::vector<std::uint64_t>{3});
}

TEST_P(Conformance, GivesAReaderOfAPartThisPartOrTheSharedSample) {
  Writer writer(stage);
  Reader reader(stage, {.masks = {"data[::3]"}});
  writer.serve(reader);
  ASSERT_EQ(writer.publish(1000), SendStatus::sent);
  const SampleHandle sample = reader.next();
  if (traits().projects) {
    EXPECT_TRUE(is_part(sample, 1000, selection("data[::3]")));
  } else {
    ASSERT_TRUE(is_image(sample, 1000));
    EXPECT_EQ(sample->parts, 0U);
  }
}

/// Returns a gate that lets every second sample pass, whatever its content.
std::shared_ptr<core::Gate> every_second() {
  const TypeSupport& type = udp::test::type_support<Image>();
  const Selection::Gate gate = type.parse_selection("* @ every 2nd").value().gate();
  const std::uint64_t hash = Selection(type.none()).with_gate(gate).value().gate_hash();
  return std::make_shared<core::Gate>(0, detail::Conditions(type.type(), gate.conditions), hash);
}

TEST_P(Conformance, GivesAReaderWithConditionsWhatPassesAndNothingElse) {
  Writer writer(stage);
  Reader choosy(stage, {.masks = {"* @ every 2nd"}, .depth = 5});
  Reader other(stage);
  choosy.hear(writer);
  other.hear(writer);
  const auto gate = every_second();
  core::Route through_gate = choosy.route();
  through_gate.gate = gate;
  writer.serve({through_gate, other.route()});
  gate->reader_begins();
  for (int n = 1; n <= 10; ++n) {
    gate->consider(detail::FieldSource::of_nothing(), n);
    gate->made(detail::FieldSource::of_nothing(), n);
    ASSERT_EQ(writer.publish(), core::SendStatus::sent);
  }
  EXPECT_EQ(other.next_sequences(10), numbers(1, 10));
  EXPECT_EQ(choosy.next_sequences(5), (std::vector<std::uint64_t>{1, 3, 5, 7, 9}));
  EXPECT_EQ(choosy.take_sequences(), std::vector<std::uint64_t>{});
  EXPECT_EQ(choosy.discarded(), 0U) << "what was withheld took no place in the queue";
}

}  // namespace
}  // namespace sft::conformance
