// The guarantees of a network for single transmissions and batches. Fallback routes carry only samples that
// are meant for them. All samples of a batch have been sent when the batch ends.
#include <utility>

#include "tests/conformance/conformance.h"

namespace sft::conformance {
namespace {

using core::Reach;
using core::SendStatus;

TEST_P(Transmissions, ReachAReaderWithAFallbackRouteOnlyIfTheyAreMeantForIt) {
  Writer writer(stage);
  // The masks differ, because with equal masks one datagram could serve both readers.
  Reader usual(stage), elsewhere(stage, {.masks = {"name"}});
  usual.hear(writer);
  elsewhere.hear(writer);
  core::Route fallback = elsewhere.route();
  fallback.fallback = true;
  writer.serve({usual.route(), fallback});
  for (const Reach reach : {Reach::usual_routes, Reach::fallback_routes_too}) {
    const core::SampleHandle sample = writer.make(10);
    ASSERT_EQ(writer.network_port().begin().send(sample, reach), SendStatus::sent);
  }
  EXPECT_EQ(usual.next_sequences(2), numbers(1, 2));
  EXPECT_EQ(elsewhere.next_sequences(1), numbers(2, 2));
}

TEST_P(Transmissions, MayBeLetGoOf) {
  Writer writer(stage);
  Reader reader(stage);
  writer.serve(reader);
  static_cast<void>(writer.network_port().begin());
  writer.network_port().begin().miss();
  ASSERT_EQ(writer.publish(), SendStatus::sent);
  EXPECT_EQ(reader.next_sequences(1), numbers(1, 1));
}

TEST_P(Transmissions, OfABatchHaveAllLeftAtItsEnd) {
  Writer writer(stage);
  Reader reader(stage);
  writer.serve(reader);
  for (std::uint64_t first = 1; first <= 21; first += 10) {
    core::Batch batch = writer.network_port().batch(core::BatchTimeout::fresh);
    for (int i = 0; i < 10; ++i) ASSERT_EQ(writer.publish(10), SendStatus::sent);
    if (first == 21) break;  // the batch is destroyed, which also sends its samples
    ASSERT_EQ(std::move(batch).flush(), 0U);
  }
  EXPECT_EQ(reader.next_sequences(30), numbers(1, 30));
}

}  // namespace
}  // namespace sft::conformance
