// A reader requests one selection after the other, with parts of fields and with conditions, while its writer
// publishes. Each sample that arrives names a selection. The sample has passed the conditions of that
// selection, and has exactly the part that the selection takes.
#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <thread>

#include "core/seam/gate.h"
#include "core/seam/gate_table.h"
#include "tests/conformance/conformance.h"
#include "tests/support/test_seed.h"

namespace sft::conformance {
namespace {

using core::SampleHandle;

/// The height of an image equals the sample's sequence.
const std::vector<std::string> texts{"data[::3] @ every 2nd",
                                     "* @ every 3rd",
                                     "height, data[5:9] @ changed(height) 4",
                                     "name, data[0] @ every 2nd and height > 50",
                                     "data[10:5000:2], stamp @ every 4th or height < 300",
                                     "stamp @ every 7th",
                                     "data[0:0] @ changed(height) 2",
                                     "data[::3] @ every 5th"};

/// A selection that the reader requests, and the decisions of its gate on all samples.
struct Choice {
  explicit Choice(const std::string& text) : wanted(selection(text)) {
    const TypeSupport& type = udp::test::type_support<Image>();
    gate = std::make_shared<core::Gate>(0, detail::Conditions(type.type(), wanted.gate().conditions),
                                        wanted.gate_hash());
  }
  void consider(const detail::FieldSource& fields, std::int64_t stamp_ns) {
    gate->consider(fields, stamp_ns);
    gate->made(fields, stamp_ns);
    ordinals.push_back(gate->passes() ? gate->ordinal() : 0);
  }
  bool has_passed(std::uint64_t sequence) const { return ordinals.at(sequence) != 0; }

  Selection wanted;
  std::shared_ptr<core::Gate> gate;
  /// The ordinals of the samples in the gate, by sequence; 0 for a withheld sample.
  std::vector<std::uint32_t> ordinals{0};
};

/// The numbers of the first and the last change whose routes may have been in force while a sample was sent.
struct Span {
  std::size_t first = 0, last = 0;
};

/// A writer, the reader whose route changes, and another reader that gets every sample.
class GateChanges {
 public:
  static constexpr std::size_t changes = 1000, bytes = 40'000;

  /// The selections follow each other in random order. In a fixed order, each selection would always follow
  /// the same selection, and "every 2nd" might pass no sample that is sent near certain changes of the
  /// selection.
  GateChanges(Stage& given, test::Random random) : stage(given) {
    for (std::size_t& text : order) text = random() % texts.size();
    std::vector<std::string> all = texts;
    all.push_back("*");
    for (const std::string& text : texts) choices.emplace_back(text);
    reader.emplace(stage, ReaderOptions{.masks = all});
    reader->hear(writer);
    other.hear(writer);
    put_in_force(0);
  }
  bool projects() const { return stage.medium->traits().projects; }
  Choice& choice(std::size_t change) { return choices[order[change]]; }
  void put_in_force(std::size_t change) {
    begun = change;
    core::Route route = reader->route(texts[order[change]]);
    route.gate = choice(change).gate;
    writer.serve({route, other.route()});
    choice(change).gate->reader_begins();
    done = change;
  }
  /// Publishes the next sample, and records the changes whose routes may have been in force.
  void publish() {
    const std::size_t slots = udp::test::type_support<Image>().index_slots();
    Span span{.first = done};
    const SampleHandle sample = writer.make(bytes, core::gate_table_bytes(choices.size()));
    ASSERT_TRUE(sample);
    const detail::SampleState state = core::state_of(*sample, slots);
    std::vector<std::shared_ptr<core::Gate>> gates;
    for (Choice& one : choices) {
      one.consider(detail::FieldSource::of_sample(state), static_cast<std::int64_t>(writer.sequence()));
      gates.push_back(one.gate);
    }
    if (!projects()) core::write_gate_table(*sample, slots, gates);
    const core::SendStatus status = writer.port().send(sample);
    span.last = begun;
    const bool may_displace = may_be_under_way && !stage.medium->traits().reliable;
    ASSERT_TRUE(status == core::SendStatus::sent || (may_displace && status == core::SendStatus::dropped));
    if (status == core::SendStatus::dropped) ++displaced;
    spans.push_back(span);
    {
      const std::scoped_lock lock(mutex);
      published = writer.sequence();
    }
    one_more.notify_one();
  }
  /// Returns true if the sample has passed at least one of the gates that may have been in force.
  bool some_passed(std::uint64_t sequence) {
    bool some = false;
    for (std::size_t i = spans[sequence].first; i <= spans[sequence].last; ++i)
      some |= choice(i).has_passed(sequence);
    return some;
  }
  bool all_passed(std::uint64_t sequence) {
    bool all = true;
    for (std::size_t i = spans[sequence].first; i <= spans[sequence].last; ++i)
      all &= choice(i).has_passed(sequence);
    return all;
  }
  bool may_have_been_in_force(const Choice& named, std::uint64_t sequence) {
    bool may = false;
    for (std::size_t i = spans[sequence].first; i <= spans[sequence].last; ++i) may |= &choice(i) == &named;
    return may;
  }
  void expect_right(const SampleHandle& sample) {
    projects() ? expect_as_named(sample) : expect_whole_with_table(sample);
  }
  /// Checks a sample that names its mask, its part and its gate.
  void expect_as_named(const SampleHandle& sample) {
    const auto named = std::ranges::find_if(choices, [&](const Choice& one) {
      return one.wanted.mask() == sample->mask && one.wanted.parts_hash() == sample->parts &&
             one.gate->id() == sample->gate;
    });
    ASSERT_NE(named, choices.end()) << "sample " << sample->sequence;
    EXPECT_TRUE(may_have_been_in_force(*named, sample->sequence)) << "sample " << sample->sequence;
    EXPECT_TRUE(named->has_passed(sample->sequence)) << "sample " << sample->sequence;
    EXPECT_EQ(named->ordinals[sample->sequence], sample->ordinal) << "sample " << sample->sequence;
    EXPECT_TRUE(is_part(sample, bytes, named->wanted));
    came.insert(&*named);
  }
  void expect_whole_with_table(const SampleHandle& sample) {
    const std::size_t slots = udp::test::type_support<Image>().index_slots();
    EXPECT_TRUE(is_image(sample, bytes));
    EXPECT_TRUE(some_passed(sample->sequence)) << "sample " << sample->sequence;
    for (const Choice& one : choices) {
      const auto ordinal = core::ordinal_in_gate(*sample, slots, one.gate->id());
      EXPECT_EQ(ordinal.value_or(0), one.ordinals[sample->sequence]) << "sample " << sample->sequence;
      if (ordinal) came.insert(&one);
    }
  }
  /// Takes and checks the samples that have arrived. If the sample with that sequence must arrive, waits for
  /// the sample.
  void take_and_compare(std::uint64_t sequence) {
    const bool has_to_come = all_passed(sequence);
    may_be_under_way |= some_passed(sequence);
    while (const SampleHandle sample = has_to_come ? reader->next() : reader->take()) {
      ASSERT_GT(sample->sequence, last);
      last = sample->sequence;
      ASSERT_NO_FATAL_FAILURE(expect_right(sample));
      if (last != sequence) continue;
      may_be_under_way = false;
      return;
    }
    ASSERT_FALSE(has_to_come) << "sample " << sequence << " did not come";
  }

  Stage& stage;
  std::array<std::size_t, changes + 1> order{};  ///< the index of the text of each change
  Writer writer{stage};
  std::optional<Reader> reader;
  Reader other{stage, {.masks = {"height, width"}}};  // its mask is one that `reader` does not accept
  std::vector<Choice> choices;
  std::vector<Span> spans{1};  ///< the changes that may have been in force for each sample, by sequence
  std::mutex mutex;
  std::condition_variable_any one_more;  ///< notified after each published sample
  std::size_t published = 0;  ///< the sequence of the last published sample; written with the mutex held
  /// The numbers of the last change that has begun, and of the last change that is complete.
  std::atomic<std::size_t> begun{0}, done{0};
  std::uint64_t last = 0;         ///< the sequence of the last sample that arrived
  bool may_be_under_way = false;  ///< whether a sample may be under way, which the next sample may displace
  std::uint64_t displaced = 0;    ///< the number of samples that newer samples have displaced
  std::set<const Choice*> came;   ///< the selections under which samples arrived
};

/// Changes the routes `times` times. Before each change at least one more sample is published.
std::jthread change_routes(GateChanges& world, std::size_t times) {
  return std::jthread([&world, times](const std::stop_token& stop) {
    std::size_t seen = 0;
    for (std::size_t i = 1; i <= times; ++i) {
      {
        std::unique_lock lock(world.mutex);
        if (!world.one_more.wait(lock, stop, [&] { return world.published != seen; })) return;
        seen = world.published;
      }
      world.put_in_force(i);
    }
  });
}

TEST_P(Conformance, GivesAReaderThatChangesItsConditionsOnlyWhatTheNamedSelectionHasLetPass) {
  SCOPED_TRACE(test::how_to_repeat());
  GateChanges world(stage, test::Random(test::test_seed()));
  std::jthread agent = change_routes(world, GateChanges::changes);
  while (world.done < GateChanges::changes) {
    ASSERT_NO_FATAL_FAILURE(world.publish());
    ASSERT_NO_FATAL_FAILURE(world.take_and_compare(world.published));
    ASSERT_TRUE(world.other.next()) << "sample " << world.published << " did not come";
  }
  agent.join();
  EXPECT_EQ(world.came.size(), texts.size());
  world.writer.serve({world.reader->route("*")});
  ASSERT_NO_FATAL_FAILURE(world.publish());
  SampleHandle sample = world.reader->next();
  while (sample && sample->sequence < world.published) {
    ASSERT_NO_FATAL_FAILURE(world.expect_right(sample));
    sample = world.reader->next();
  }
  EXPECT_TRUE(is_image(sample, GateChanges::bytes)) << "nothing is withheld any more";
  EXPECT_EQ(stage.there->counters().over_limit, world.displaced)
      << "nothing else was lost, and all is counted";
  EXPECT_EQ(stage.here->counters().malformed, 0U);
}

}  // namespace
}  // namespace sft::conformance
