// The suite on shared memory, each test on a host and with a daemon of its own.
#include "conformance.h"
#include "tests/shm/shm_fixture.h"

namespace sft::conformance {
namespace {

class ShmMedium final : public Medium {
 public:
  ~ShmMedium() override { test::end_daemon(); }

  std::string refusal() override { return test::isolation_refusal(); }
  Traits traits() const override { return {.projects = false, .counts_before_first_taken = false}; }
  std::unique_ptr<core::Transport> open() override {
    auto transport = shm::open_shm_transport(test::own_daemon()).value();
    const auto ready = [&] {
      return transport->poll(std::chrono::steady_clock::now()) == core::Availability::ready;
    };
    EXPECT_TRUE(eventually(ready, patience)) << transport->description();
    return transport;
  }
  core::Locator locator(const core::Transport&, const core::DoorbellAddress& bell) override { return bell; }
};

const auto iceoryx = testing::Values(MediumChoice{"Iceoryx", std::make_unique<ShmMedium>});

INSTANTIATE_TEST_SUITE_P(Shm, Conformance, iceoryx, name_of);

// There is one sample, whole, for all of a writer's readers.
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(LateReaders);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Projection);

class ShmSamples : public Conformance {};
INSTANTIATE_TEST_SUITE_P(Shm, ShmSamples, iceoryx, name_of);

TEST_P(ShmSamples, AreNotSentToOneLateReaderApartWhichGetsWhatComesInstead) {
  Writer writer(stage);
  Reader early(stage), late(stage);
  early.hear(writer);
  late.hear(writer);
  core::Route to_late = late.route();
  to_late.history = 1;
  const core::SampleHandle retained = writer.make(10);
  writer.serve({early.route(), to_late});
  ASSERT_EQ(writer.publish(), core::SendStatus::sent);
  writer.port().send_history(to_late, {retained});
  EXPECT_TRUE(writer.port().history_sent(to_late.reader));
  EXPECT_EQ(early.take_sequences(), numbers(2, 2));
  EXPECT_EQ(late.take_sequences(), numbers(2, 2));
  EXPECT_EQ(late.port().history(writer.id()), core::HistoryProgress::came) << "it awaits none";
}

}  // namespace
}  // namespace sft::conformance
