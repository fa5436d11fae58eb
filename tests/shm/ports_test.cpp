// Writers and readers while all is well: what arrives, what it costs, and what happens at the limits.
#include <atomic>
#include <cstring>
#include <thread>

#include "core/doorbell.h"
#include "core/rate_gate.h"
#include "shm_fixture.h"
#include "shm_transport/iceoryx.h"

namespace sft::test {
namespace {

using core::SampleHandle;
using core::SendStatus;

class ShmPorts : public ShmNodeTest {};

TEST_F(ShmPorts, DeliverTheChunkThatTheWriterFilled) {
  Writer writer(node(), 1);
  Reader reader(node());
  ASSERT_TRUE(reader.connects_to(1));
  const SampleHandle sent = writer.loan(1000);
  std::memset(data_of(*sent), 42, 1000);
  ASSERT_EQ(writer.send(sent, 1000), SendStatus::sent);
  const SampleHandle got = reader.next();
  ASSERT_TRUE(got);
  EXPECT_EQ(got->data, sent->data);
  EXPECT_EQ(sequence_of(got), 1U);
  EXPECT_EQ(data_of(*got)[999], std::byte{42});
  EXPECT_TRUE(got->mask.is_full());
  EXPECT_GT(got->receive_stamp_ns, 0);
}

TEST_F(ShmPorts, LetAReaderSeeOnlyTheCheckedBytes) {
  Writer writer(node(), 1);
  Reader reader(node());
  ASSERT_TRUE(reader.connects_to(1));
  writer.send_frame(100);
  const SampleHandle got = reader.next();
  ASSERT_TRUE(got);
  EXPECT_EQ(got->capacity, frame_bytes(100));
}

TEST_F(ShmPorts, TellWhatTheHeaderSaidWhenItWasChecked) {
  Writer writer(node(), 1);
  Reader reader(node());
  ASSERT_TRUE(reader.connects_to(1));
  const SampleHandle sent = writer.loan(100);
  writer.send(sent, 100);
  const SampleHandle got = reader.next();
  ASSERT_TRUE(got);
  sent->header().writer = 2;
  sent->header().sequence = ~std::uint64_t{0};
  EXPECT_EQ(got->writer, 1U);
  EXPECT_EQ(got->sequence, 1U);
}

TEST_F(ShmPorts, TouchOnlyTheFirstPagesOfALargeSampleForItsScalars) {
  constexpr std::uint32_t six_megabytes = 6'000'000;
  Writer writer(node(), 1);
  Process peer = start_peer({"count-faults", "1", std::to_string(six_megabytes)});
  ASSERT_EQ(peer.line(), "subscribed");
  const SampleHandle sent = writer.loan(six_megabytes);
  ASSERT_TRUE(sent);
  std::memset(data_of(*sent), 1, six_megabytes);
  writer.send(sent, six_megabytes);
  long scalar_faults = -1;
  long data_faults = -1;
  const std::string line = peer.line();
  ASSERT_EQ(std::sscanf(line.c_str(), "%ld %ld", &scalar_faults, &data_faults), 2) << line;
  EXPECT_LE(scalar_faults, 64) << "of 1465 pages; the kernel maps 16 around each fault";
  EXPECT_GE(data_faults, 80) << "all that the scalars did not touch";
}

TEST_F(ShmPorts, AreNotConnectedBeforeTheWriterExists) {
  Reader reader(node());
  ASSERT_TRUE(reader.port().connect({.writer = 5, .max_sample_bytes = 1000}));
  EXPECT_FALSE(reader.port().connected(5));
  Writer writer(node(), 5);
  EXPECT_TRUE(eventually([&] { return reader.port().connected(5); }));
  EXPECT_FALSE(reader.port().connected(6));
}

TEST_F(ShmPorts, KeepOneDepthOfWhatDepartedWritersLeftAndCountTheRest) {
  constexpr std::uint32_t depth = 3;
  Reader reader(node(), depth);
  ChunkCounter chunks(node(), 4'000'000);
  const std::size_t before = chunks.free();
  for (core::EndpointId id = 1; id <= 6; ++id) {
    Writer writer(node(), id);
    ASSERT_TRUE(reader.connects_to(id));
    for (int i = 0; i < 2; ++i) writer.send_frame(4'000'000);
    reader.port().disconnect(id);
  }
  EXPECT_TRUE(chunks.comes_to(before - depth));
  EXPECT_EQ(reader.port().lost_unnoticed(), 4 * 2U) << "of those of which nothing is left";
  EXPECT_EQ(reader.port().discarded(), 4 * 2U + 1);
  std::vector<std::pair<core::EndpointId, std::uint64_t>> taken;
  while (const SampleHandle got = reader.take()) taken.emplace_back(got->writer, got->sequence);
  EXPECT_EQ(taken, (decltype(taken){{5, 2}, {6, 1}, {6, 2}}));
  EXPECT_EQ(reader.port().lost_unnoticed(), 4 * 2U + 1) << "no gap tells of the fifth one's first";
  EXPECT_TRUE(chunks.comes_to(before));
}

TEST_F(ShmPorts, TakeFromSeveralWritersInTurn) {
  Writer first(node(), 1);
  Writer second(node(), 2);
  Reader reader(node());
  ASSERT_TRUE(reader.connects_to(1));
  ASSERT_TRUE(reader.connects_to(2));
  for (int i = 0; i < 2; ++i) {
    first.send_frame();
    second.send_frame();
  }
  std::vector<core::EndpointId> writers;
  while (const SampleHandle got = reader.take()) writers.push_back(got->header().writer);
  ASSERT_EQ(writers.size(), 4U);
  EXPECT_NE(writers[0], writers[1]);
  EXPECT_NE(writers[2], writers[3]);
}

TEST_F(ShmPorts, SkipMalformedSamplesAndCountThem) {
  Writer writer(node(), 1);
  Reader reader(node());
  ASSERT_TRUE(reader.connects_to(1));
  for (const std::uint32_t body_bytes : {0xFFFF'FFFFU, 5000U}) {
    const SampleHandle bad = writer.loan(100);
    write_frame(*bad, 1, 1, 100);
    bad->header().body_bytes = body_bytes;
    writer.port().send(bad);
  }
  writer.send_frame();
  EXPECT_TRUE(reader.next());
  EXPECT_FALSE(reader.take());
  EXPECT_EQ(reader.port().discarded(), 2U);
  EXPECT_EQ(node()->counters().malformed, 2U);
}

// The header of a chunk lies in the shared memory before the sample: any writer can change it.
TEST_F(ShmPorts, RefuseAChunkThatClaimsToReachBeyondTheSegment) {
  Writer writer(node(), 1);
  Reader reader(node());
  ASSERT_TRUE(reader.connects_to(1));
  const SampleHandle bad = writer.loan(100);
  auto* header = iox::mepoo::ChunkHeader::fromUserPayload(bad->data);
  const std::uint32_t honest = header->userPayloadSize();
  std::byte* const fields = reinterpret_cast<std::byte*>(header);
  std::size_t at = 0;
  for (std::uint32_t value = 0; at + sizeof value <= sizeof *header; at += sizeof value) {
    std::memcpy(&value, fields + at, sizeof value);
    const std::uint32_t changed = value + 8;
    std::memcpy(fields + at, &changed, sizeof changed);
    const bool is_size = header->userPayloadSize() == honest + 8;
    std::memcpy(fields + at, &value, sizeof value);
    if (is_size) break;
  }
  ASSERT_LT(at, sizeof *header);
  const std::uint32_t beyond = 0xFFFF'FFF0;
  std::memcpy(fields + at, &beyond, sizeof beyond);
  EXPECT_EQ(writer.send(bad, 100), SendStatus::sent);
  EXPECT_FALSE(reader.take());
  EXPECT_EQ(reader.port().discarded(), 1U);
  EXPECT_EQ(node()->counters().malformed, 1U);
  std::memcpy(fields + at, &honest, sizeof honest);
}

TEST_F(ShmPorts, RefuseALoanBeyondTheLimitAndCountIt) {
  shm::ShmOptions options = no_daemon();
  options.held_limit = 12;
  Node other(options);
  ASSERT_TRUE(other.becomes_ready()) << other->description();
  Writer writer(other, 1);
  std::vector<SampleHandle> loans;
  for (int i = 0; i < 12; ++i) loans.push_back(writer.loan(100));
  for (const SampleHandle& loan : loans) EXPECT_TRUE(loan);
  EXPECT_FALSE(writer.loan(100));
  EXPECT_EQ(other->counters().over_limit, 1U);
  loans.pop_back();
  EXPECT_TRUE(writer.loan(100));
}

TEST_F(ShmPorts, RefuseWhatNoPoolCanHold) {
  Writer writer(node(), 1);
  EXPECT_FALSE(writer.loan(100'000'000));
  EXPECT_FALSE(writer.loan(0xFFFF'FF00));
  EXPECT_FALSE(writer.port().loan(~std::size_t{0}));
  EXPECT_TRUE(writer.loan(100));
}

TEST_F(ShmPorts, RunOutOfChunksWithoutTouchingMuchLargerOnes) {
  ChunkCounter large_chunks(node(), 16 << 20);
  const std::size_t large = large_chunks.free();
  std::vector<std::unique_ptr<Writer>> writers;
  std::vector<SampleHandle> loans;
  for (core::EndpointId id = 100; id < 120; ++id) {
    writers.push_back(std::make_unique<Writer>(node(), id));
    while (SampleHandle loan = writers.back()->loan(3'000'000)) loans.push_back(std::move(loan));
  }
  Writer writer(node(), 1);
  EXPECT_FALSE(writer.loan(3'000'000));
  EXPECT_EQ(large_chunks.free(), large);
}

TEST_F(ShmPorts, GiveUnsentLoansBack) {
  ChunkCounter chunks(node(), 4'000'000);
  const std::size_t before = chunks.free();
  Writer writer(node(), 1);
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(writer.loan(4'000'000)) << i;
  EXPECT_EQ(chunks.free(), before);
}

TEST_F(ShmPorts, KeepASampleThatHadNoRouteUnwrittenToo) {
  Writer writer(node(), 1);
  writer.port().set_routes({});
  std::vector<SampleHandle> history;
  for (std::uint32_t i = 0; i < 100; ++i) {
    history.push_back(writer.loan(100));
    ASSERT_TRUE(history.back()) << i;
    writer.send(history.back(), 100);
  }
  for (std::size_t i = 0; i < history.size(); ++i) EXPECT_EQ(sequence_of(history[i]), i + 1);
}

TEST_F(ShmPorts, UseTheSameChunkAgainOnceNobodyHoldsIt) {
  Writer writer(node(), 1);
  writer.send_frame();
  const std::byte* first = writer.loan(100)->data;
  for (int i = 0; i < 10; ++i) {
    const SampleHandle sample = writer.loan(100);
    EXPECT_EQ(sample->data, first);
    writer.send(sample, 100);
  }
}

TEST_F(ShmPorts, HoldNoMoreThanTheLimitAndLeaveTheRestInTheQueue) {
  shm::ShmOptions options = no_daemon();
  options.held_limit = 2;
  Node other(options);
  ASSERT_TRUE(other.becomes_ready()) << other->description();
  Writer writer(node(), 1);
  Reader reader(other);
  ASSERT_TRUE(reader.connects_to(1));
  for (int i = 0; i < 4; ++i) writer.send_frame();
  SampleHandle first = reader.next();
  const SampleHandle second = reader.next();
  EXPECT_FALSE(reader.take());
  EXPECT_FALSE(reader.take());
  EXPECT_EQ(reader.port().held_too_many(), 1U) << "once, as long as nothing is given back";
  first.reset();
  first = reader.next();
  EXPECT_EQ(sequence_of(first), 3U);
  EXPECT_FALSE(reader.take());
  EXPECT_EQ(reader.port().held_too_many(), 2U);
}

TEST_F(ShmPorts, LetSamplesBeReleasedOnAnyThread) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "the thread sanitizer does not see what iceoryx's library synchronises";
#endif
  Writer writer(node(), 1);
  Reader reader(node(), 64);
  ASSERT_TRUE(reader.connects_to(1));
  std::atomic<std::uint64_t> last{0};
  std::thread consumer([&] {
    std::vector<SampleHandle> held(5);
    for (std::size_t i = 0; last < 20'000;) {
      if (SampleHandle sample = reader.take()) {
        last = sequence_of(sample);
        held[i++ % held.size()] = std::move(sample);
      }
    }
  });
  while (writer.sequence() < 20'000 || last < 20'000) writer.send_frame();
  consumer.join();
  EXPECT_EQ(node()->counters().malformed, 0U);
}

TEST_F(ShmPorts, RingTheDoorbellOfASleepingReader) {
  const auto page = core::DoorbellPage::create();
  core::Doorbell& bell = page->at(3);
  Writer writer(node(), 1);
  Reader reader(node());
  ASSERT_TRUE(reader.connects_to(1));
  const core::DoorbellAddress address{page->id(), 3};
  const FieldMask full = frame_type().full();
  writer.port().set_routes({{.reader = 1, .destination = address, .mask = full},
                            {.reader = 2, .destination = address, .mask = full}});
  SampleHandle got;
  std::thread sleeper(
      [&] { bell.wait(Clock::now() + 5s, [&] { return static_cast<bool>(got = reader.take()); }); });
  EXPECT_TRUE(eventually([&] { return bell.sleepers == 1; }));
  const auto before = bell.rings.load();
  writer.send_frame();
  sleeper.join();
  EXPECT_EQ(bell.rings, before + 1) << "two readers behind one doorbell are one ring";
  if (!got) got = reader.take();
  EXPECT_TRUE(got);
}

TEST_F(ShmPorts, RingTheDoorbellOfALateReaderThatSleepsWhateverItsRate) {
  const auto page = core::DoorbellPage::create();
  core::Doorbell& bell = page->at(3);
  Writer writer(node(), 1);
  std::thread sleeper([&] { bell.wait(Clock::now() + 20s, [&] { return bell.rings > 0; }); });
  EXPECT_TRUE(eventually([&] { return bell.sleepers == 1; }));
  core::Route late{
      .reader = 5, .destination = core::DoorbellAddress{page->id(), 3}, .mask = {}, .history = 2};
  late.gate = std::make_shared<core::RateGate>(1'000'000);  // nothing has passed it
  const auto begin = Clock::now();
  EXPECT_TRUE(writer.port().begin_with(late, {}, 0));
  sleeper.join();
  EXPECT_LT(Clock::now() - begin, 10s) << "it slept on until its deadline";
}

// Gaps have other reasons, too: samples that went to this reader by UDP. They are not taken for what a queue
// pushed out long afterwards.
TEST_F(ShmPorts, CountNoGapOfLongAgoAsPushedOut) {
  constexpr std::uint32_t depth = 4;
  Writer writer(node(), 1);
  Reader reader(node(), depth);
  ASSERT_TRUE(reader.connects_to(1));
  std::uint64_t sequence = 0;
  const auto send = [&] {
    const SampleHandle sample = writer.loan(100);
    write_frame(*sample, 1, ++sequence, 100);
    ASSERT_EQ(writer.port().send(sample), SendStatus::sent);
  };
  send();
  ASSERT_TRUE(reader.take());
  sequence += 1000;
  for (int i = 0; i < 600; ++i) {  // more than any queue holds
    send();
    ASSERT_TRUE(reader.take()) << i;
  }
  for (std::uint32_t i = 0; i < depth + 3; ++i) send();
  while (reader.take()) continue;
  EXPECT_EQ(reader.port().discarded(), 3U);
}

TEST_F(ShmPorts, OfTwoNodesInOneProcessBothWork) {
  Node other(no_daemon());
  ASSERT_TRUE(other.becomes_ready()) << other->description();
  Writer writer(node(), 1);
  Writer back(other, 2);
  Reader reader(other);
  Reader back_reader(node());
  ASSERT_TRUE(reader.connects_to(1));
  ASSERT_TRUE(back_reader.connects_to(2));
  for (int i = 0; i < 100; ++i) {
    writer.send_frame();
    back.send_frame();
    EXPECT_TRUE(reader.next());
    EXPECT_TRUE(back_reader.next());
  }
  EXPECT_EQ(names_in("/tmp", "sft_node").size(), 1U) << "they share one registration";
}

}  // namespace
}  // namespace sft::test
