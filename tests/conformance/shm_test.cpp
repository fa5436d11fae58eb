// The suite on shared memory. Each test has its own isolated host and its own daemon.
#include <atomic>
#include <optional>
#include <thread>
#include <utility>

#include "core/seam/gate.h"
#include "tests/conformance/conformance.h"
#include "tests/transports/shm/shm_fixture.h"

namespace sft::conformance {
namespace {

using namespace detail;

class ShmMedium final : public Medium {
 public:
  explicit ShmMedium(bool reliable = false) : reliable_(reliable) {
    if (test::isolation_refusal().empty()) shm_.emplace(shm_mebibytes);
  }
  ~ShmMedium() override { test::end_daemon(); }

  std::string refusal() override { return test::isolation_refusal(); }
  Traits traits() const override {
    return {.projects = false, .counts_before_first_taken = false, .reliable = reliable_};
  }
  AnyTransport open() override {
    shm::ShmOptions options = test::own_daemon();
    options.port_wait = options.port_deadline =
        // The time limit is long, because the daemon may get the CPU late. A node would repeat its request
        // instead.
        hang_timeout;
    auto transport = shm::open_shm_transport(options).value();
    const auto ready = [&] {
      return transport->poll(std::chrono::steady_clock::now()) == core::Availability::ready;
    };
    EXPECT_TRUE(eventually(ready, hang_timeout)) << transport->description();
    return transport;
  }
  core::Locator locator(const AnyTransport&, const core::DoorbellAddress& bell) override { return bell; }

 private:
  static constexpr unsigned shm_mebibytes = 1600;  // enough memory for the largest samples
  const bool reliable_;
  std::optional<test::ShmOfSize> shm_;
};

const auto iceoryx = testing::Values(MediumChoice{"Iceoryx", [] { return std::make_unique<ShmMedium>(); }});
const auto reliable_iceoryx =
    testing::Values(MediumChoice{"Iceoryx", [] { return std::make_unique<ShmMedium>(true); }});

INSTANTIATE_TEST_SUITE_P(Shm, Conformance, iceoryx, name_of);
INSTANTIATE_TEST_SUITE_P(Shm, BackPressure, reliable_iceoryx, name_of);

// All readers of a writer share one whole sample, so the following suites do not apply.
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LateReaders);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Projection);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Transmissions);

class ShmSamples : public Conformance {};
INSTANTIATE_TEST_SUITE_P(Shm, ShmSamples, iceoryx, name_of);

/// Tests with a writer that retains three samples, and a reader that wants the retained samples first.
class ShmHistory : public Conformance {
 protected:
  void SetUp() override {
    Conformance::SetUp();
    if (IsSkipped()) return;
    writer.emplace(stage);
    early.emplace(stage);
    late.emplace(stage);
    early->hear(*writer);
    connect();
    for (int i = 0; i < 3; ++i) retained.push_back(writer->make(10));
    to_late = late->route();
    to_late.history = 4;
  }
  void connect() {
    ASSERT_TRUE(late->port().connect({.writer = writer->id(), .history_first = true}));
    ASSERT_TRUE(eventually([&] { return late->port().connected(writer->id()); }, hang_timeout));
  }
  std::optional<std::uint64_t> held_back() { return writer->lending_port().held_back(to_late.reader); }
  bool begin(std::optional<std::uint64_t> held_back) {
    return held_back && writer->lending_port().begin_with(to_late, retained, *held_back);
  }

  std::optional<Writer> writer;
  std::optional<Reader> early, late;
  std::vector<core::SampleHandle> retained;
  core::Route to_late;
};
INSTANTIATE_TEST_SUITE_P(Shm, ShmHistory, iceoryx, name_of);

TEST_P(ShmHistory, ComesBeforeWhatIsSentMeanwhileAndLacksNothingOfThat) {
  writer->serve({early->route(), to_late});
  const auto before = held_back();
  const core::SampleHandle meanwhile = writer->make(10);
  ASSERT_EQ(writer->port().send(meanwhile), core::SendStatus::sent);
  EXPECT_EQ(early->next_sequences(1), numbers(4, 4)) << "it waits for nobody";
  EXPECT_FALSE(late->take());
  EXPECT_EQ(late->port().history(writer->id()), core::HistoryProgress::awaited);
  EXPECT_FALSE(begin(before)) << "the sample sent meanwhile would be missing";
  retained.push_back(meanwhile);
  EXPECT_TRUE(begin(held_back()));
  EXPECT_FALSE(held_back()) << "it waits no more";
  ASSERT_EQ(writer->publish(), core::SendStatus::sent);
  const core::SampleHandle first = late->next();
  ASSERT_TRUE(is_image(first, 10));
  EXPECT_EQ(first->sequence, 1U);
  EXPECT_EQ(first->oldest_retained, 1U);
  EXPECT_EQ(late->next_sequences(4), numbers(2, 5));
  EXPECT_EQ(late->port().history(writer->id()), core::HistoryProgress::came);
  EXPECT_EQ(early->next_sequences(1), numbers(5, 5));
}

TEST_P(ShmHistory, MayBeEmpty) {
  writer->serve({to_late});
  retained.clear();
  EXPECT_TRUE(begin(held_back()));
  ASSERT_EQ(writer->publish(), core::SendStatus::sent);
  EXPECT_EQ(late->next_sequences(1), numbers(4, 4));
}

TEST_P(ShmHistory, IsGivenAgainToAReaderThatConnectsAgain) {
  writer->serve({to_late});
  EXPECT_TRUE(begin(held_back()));
  EXPECT_EQ(late->next_sequences(3), numbers(1, 3));
  late->port().disconnect(writer->id());
  connect();
  EXPECT_TRUE(eventually([&] { return begin(held_back()); }, hang_timeout));
  EXPECT_EQ(late->next_sequences(3), numbers(1, 3));
}

TEST_P(ShmHistory, AReaderThatIsOwedNoneDoesNotWaitForIt) {
  to_late.history = 0;
  writer->serve({to_late});
  EXPECT_FALSE(held_back());
  ASSERT_EQ(writer->publish(), core::SendStatus::sent);
  EXPECT_EQ(late->next_sequences(1), numbers(4, 4));
}

TEST_P(ShmSamples, ComeToALateReaderThatDoesNotWaitForWhatWasRetained) {
  Writer writer(stage);
  Reader early(stage), late(stage);
  early.hear(writer);
  late.hear(writer);
  core::Route to_late = late.route();
  to_late.history = 1;
  const core::SampleHandle retained = writer.make(10);
  writer.serve({early.route(), to_late});
  ASSERT_EQ(writer.publish(), core::SendStatus::sent);
  EXPECT_EQ(early.take_sequences(), numbers(2, 2));
  EXPECT_EQ(late.take_sequences(), numbers(2, 2));
  EXPECT_EQ(late.port().history(writer.id()), core::HistoryProgress::came) << "it awaits none";
}

/// Returns a gate that lets every sample pass if `is_open` is true. Otherwise no sample passes the gate.
std::shared_ptr<core::Gate> gate(bool is_open) {
  const TypeSupport& type = udp::test::type_support<Image>();
  const Selection any = selection(is_open ? "* @ height >= 0" : "* @ height < 0");
  auto made = std::make_shared<core::Gate>(0, detail::Conditions(type.type(), any.gate().conditions),
                                           any.gate_hash());
  if (is_open) made->reader_begins();
  return made;
}

class ShmWaiting : public Conformance {};
INSTANTIATE_TEST_SUITE_P(Shm, ShmWaiting, reliable_iceoryx, name_of);

/// The test enforces an order of events. First the writer chooses the readers to wake. Then the reader
/// changes its conditions. Last, the writer puts the sample into the reader's queue.
TEST_P(ShmWaiting, WakesAReaderThatChangesItsConditionsWhileTheWriterWaitsForAnother) {
  using namespace std::chrono_literals;
  constexpr std::uint32_t depth = 8;
  Writer writer(stage, 1, hang_timeout);
  Reader full(stage, {.depth = depth}), changing(stage);
  full.hear(writer);
  changing.hear(writer);
  const auto closed = gate(false), open = gate(true);
  core::Route route = changing.route();
  route.gate = closed;
  writer.serve({full.route(), route});
  std::atomic<std::uint32_t> begun{0};
  std::jthread publishing([&] {
    while (begun <= depth) {
      ++begun;
      for (const auto& one : {closed, open}) one->consider(detail::FieldSource::of_nothing(), begun);
      writer.publish();
    }
  });
  std::uint32_t before = 0;
  const auto waits = [&] {
    const std::uint32_t now = begun;
    return std::exchange(before, now) == depth + 1 && now == depth + 1;
  };
  ASSERT_TRUE(eventually(waits, hang_timeout, 100ms));
  const std::uint32_t rings = changing.rings();
  route.gate = open;
  writer.serve({full.route(), route});
  EXPECT_TRUE(full.take());
  publishing.join();
  const core::SampleHandle sample = changing.take();
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->sequence, depth + 1);
  EXPECT_NE(changing.rings(), rings);
}

}  // namespace
}  // namespace sft::conformance
