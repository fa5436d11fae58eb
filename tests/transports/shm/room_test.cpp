// The room in a queue in shared memory: its limit in bytes, and how long a writer waits for room there.
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

using core::SampleHandle;
using core::SendStatus;

class RoomInAQueue : public ShmNodeTest {
 protected:
  static constexpr core::EndpointId writer_id = 1;

  /// A reader takes one sample. Of nine further ones, as many wait for it as have the bytes that it asked
  /// for.
  void expect_newest_five_of_ten(Writer& writer) {
    Reader reader(node(), 16, reader_id, 1 << 19);
    ASSERT_TRUE(reader.connects_to(writer_id));
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
};

TEST_F(RoomInAQueue, IsForNoMoreBytesThanTheReaderAskedFor) {
  Writer writer(node(), writer_id);
  expect_newest_five_of_ten(writer);
}

TEST_F(RoomInAQueue, IsForNoMoreBytesThanTheReaderAskedForAlsoBesideOneThatIsNotServed) {
  Writer writer(node(), writer_id);
  Reader other(node(), 16, reader_id + 1);
  ASSERT_TRUE(other.connects_to(writer_id));
  expect_newest_five_of_ten(writer);
  EXPECT_FALSE(other.take());
}

TEST_F(RoomInAQueue, IsForNoMoreBytesOfRetainedSamplesThanALateReaderAskedFor) {
  Writer writer(node(), writer_id);
  Reader late(node(), 16, reader_id + 1, 1 << 18);
  ASSERT_TRUE(late.port().connect({.writer = writer_id, .max_sample_bytes = 200'000, .history_first = true}));
  ASSERT_TRUE(eventually([&] { return late.port().connected(writer_id); }));
  std::vector<SampleHandle> retained;
  for (std::uint64_t sequence = 1; sequence <= 5; ++sequence) {
    retained.push_back(writer.loan(100'000));
    write_frame(*retained.back(), writer_id, sequence, 100'000);
  }
  const core::Route route{
      .reader = reader_id + 1, .destination = core::DoorbellAddress{}, .selection = {}, .history = 5};
  ASSERT_TRUE(writer.port().begin_with(route, retained, 0));
  EXPECT_EQ(sequence_of(late.next()), 4U);
  EXPECT_EQ(sequence_of(late.next()), 5U);
  EXPECT_FALSE(late.take());
}

TEST_F(RoomInAQueue, ThatAWriterWaitsForCountsAgainstItsTimeout) {
  constexpr std::chrono::nanoseconds max_blocking = 20ms;
  const auto port =
      node()->open_writer({.id = writer_id, .type = &frame_type(), .max_blocking = max_blocking}).value();
  port->set_routes({{.reader = reader_id,
                     .destination = core::DoorbellAddress{},
                     .selection = frame_type().full(),
                     .reliable = true}});
  Reader reader(node(), 1);
  const core::Source source{.writer = writer_id, .max_sample_bytes = 1000, .reliable = true, .waits = true};
  ASSERT_TRUE(
      eventually([&] { return reader.port().connect(source) && reader.port().connected(writer_id); }));
  const auto send = [&](std::uint64_t sequence) {
    const SampleHandle sample = port->loan(frame_bytes(100));
    write_frame(*sample, writer_id, sequence, 100);
    return port->send(sample);
  };
  EXPECT_EQ(send(1), SendStatus::sent);
  EXPECT_EQ(port->time_left(), max_blocking) << "there was room";
  EXPECT_EQ(send(2), SendStatus::displaced);
  EXPECT_EQ(port->time_left(), 0ns);
}

class SamplesOfDepartedWriters : public ShmNodeTest {};

TEST_F(SamplesOfDepartedWriters, HaveNoMoreBytesThanTheReaderAskedFor) {
  Reader reader(node(), 10, reader_id, 10'000'000);
  ChunkCounter chunks(node(), 4'000'000);
  const std::size_t before = chunks.free();
  for (core::EndpointId id = 1; id <= 6; ++id) {
    Writer writer(node(), id);
    ASSERT_TRUE(reader.connects_to(id));
    writer.send_frame(4'000'000);
    reader.port().disconnect(id);
  }
  EXPECT_TRUE(chunks.comes_to(before - 2));
  EXPECT_EQ(reader.port().counters().lost_unnoticed, 4U);
  EXPECT_EQ(sequence_of(reader.take()), 1U);
  EXPECT_EQ(reader.take()->writer, 6U);
  EXPECT_FALSE(reader.take());
  EXPECT_TRUE(chunks.comes_to(before));
}

}  // namespace
}  // namespace sft::test
