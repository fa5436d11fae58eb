// The room in a queue in shared memory: its limit in bytes, and how long a writer waits for room there.
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

using core::SampleHandle;
using core::SendStatus;

class RoomInAQueue : public ShmNodeTest {};

TEST_F(RoomInAQueue, IsForNoMoreBytesThanTheReaderAskedFor) {
  Writer writer(node(), 1);
  Reader reader(node(), 16, reader_id, 1 << 19);  // five frames of this size
  ASSERT_TRUE(reader.connects_to(1));
  writer.send_frame(100'000);
  EXPECT_TRUE(reader.next());
  for (int i = 0; i < 9; ++i) writer.send_frame(100'000);
  for (std::uint64_t sequence = 6; sequence <= 10; ++sequence) {
    const SampleHandle got = reader.take();
    ASSERT_TRUE(got);
    EXPECT_EQ(got->sequence, sequence);
  }
  EXPECT_FALSE(reader.take());
  EXPECT_EQ(reader.port().counters().discarded, 4U);
}

TEST_F(RoomInAQueue, ThatAWriterWaitsForCountsAgainstItsTimeout) {
  constexpr std::chrono::nanoseconds max_blocking = 20ms;
  const auto port =
      node()->open_writer({.id = 1, .type = &frame_type(), .max_blocking = max_blocking}).value();
  port->set_routes({{.reader = reader_id,
                     .destination = core::DoorbellAddress{},
                     .selection = frame_type().full(),
                     .reliable = true}});
  Reader reader(node(), 1);
  const core::Source source{.writer = 1, .max_sample_bytes = 1000, .reliable = true, .waits = true};
  ASSERT_TRUE(eventually([&] { return reader.port().connect(source) && reader.port().connected(1); }));
  const auto send = [&](std::uint64_t sequence) {
    const SampleHandle sample = port->loan(frame_bytes(100));
    write_frame(*sample, 1, sequence, 100);
    return port->send(sample);
  };
  EXPECT_EQ(send(1), SendStatus::sent);
  EXPECT_EQ(port->time_left(), max_blocking) << "there was room";
  EXPECT_EQ(send(2), SendStatus::displaced);
  EXPECT_EQ(port->time_left(), 0ns);
}

}  // namespace
}  // namespace sft::test
