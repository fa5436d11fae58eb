// A reader in shared memory keeps its counts when writers are closed and others are opened.
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

using core::SampleHandle;

class ShmCounts : public ShmNodeTest {};

// If the counts of a subscriber decreased, its next event would be missing.
TEST_F(ShmCounts, StayWhenTheirWriterGoes) {
  Node other(no_daemon_and_held_at_most(2));
  ASSERT_TRUE(other.becomes_ready()) << other->description();
  Reader reader(other, 4);
  for (std::uint64_t round = 1; round <= 3; ++round) {
    Writer writer(node(), round);
    ASSERT_TRUE(reader.connects_to(round));
    writer.send_frame();
    SampleHandle first = reader.next();
    first.reset();
    for (int i = 0; i < 7; ++i) writer.send_frame();
    first = reader.next();
    SampleHandle second = reader.next();
    EXPECT_FALSE(reader.take()) << "no more than two may be held";
    const auto expect_counts = [&] {
      EXPECT_EQ(reader.port().held_too_many(), round);
      EXPECT_EQ(other->counters().over_limit, round);
      EXPECT_EQ(reader.port().counters().discarded, 3 * round) << "four of seven are kept";
    };
    expect_counts();
    reader.port().disconnect(round);
    expect_counts();
    first.reset();
    second.reset();
    EXPECT_TRUE(reader.take());
    EXPECT_TRUE(reader.take());
    EXPECT_FALSE(reader.take());
    expect_counts();
  }
}

}  // namespace
}  // namespace sft::test
