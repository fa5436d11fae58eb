// Writers and readers with a working daemon: the samples that arrive, their cost, and the behaviour at
// limits.
#include <array>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <thread>

#include "core/platform/doorbell.h"
#include "core/seam/gate.h"
#include "shm_transport/host/iceoryx.h"
#include "tests/transports/shm/shm_fixture.h"

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

TEST_F(ShmPorts, ReportTheHeaderAsItWasWhenItWasChecked) {
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
  EXPECT_LE(scalar_faults, 64) << "the sample has 1465 pages, and the kernel maps 16 around each fault";
  EXPECT_GE(data_faults, 80) << "the data must touch all pages that the scalars did not touch";
}

TEST_F(ShmPorts, AreNotConnectedBeforeTheWriterExists) {
  Reader reader(node());
  ASSERT_TRUE(reader.port().connect({.writer = 5, .max_sample_bytes = 1000}));
  EXPECT_FALSE(reader.port().connected(5));
  Writer writer(node(), 5);
  EXPECT_TRUE(eventually([&] { return reader.port().connected(5); }));
  EXPECT_FALSE(reader.port().connected(6));
}

TEST_F(ShmPorts, KeepOneDepthOfSamplesOfDepartedWritersAndCountTheRest) {
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
  EXPECT_EQ(reader.port().counters().lost_unnoticed, 4 * 2U) << "of those of which nothing is left";
  EXPECT_EQ(reader.port().counters().discarded, 4 * 2U + 1);
  std::vector<std::pair<core::EndpointId, std::uint64_t>> taken;
  while (const SampleHandle got = reader.take()) taken.emplace_back(got->writer, got->sequence);
  EXPECT_EQ(taken, (decltype(taken){{5, 2}, {6, 1}, {6, 2}}));
  EXPECT_EQ(reader.port().counters().lost_unnoticed, 4 * 2U + 1) << "no gap tells of the fifth one's first";
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
  EXPECT_EQ(reader.port().counters().discarded, 2U);
  EXPECT_EQ(node()->counters().malformed, 2U);
}

/// A chunk with a forged header. The chunk's header is in shared memory in front of the sample, so any
/// writer can change it.
class ForgedChunk : public ShmPorts {
 protected:
  void SetUp() override {
    ShmPorts::SetUp();
    if (IsSkipped()) return;
    writer_.emplace(node(), 1);
    reader_.emplace(node());
    ASSERT_TRUE(reader_->connects_to(1));
    bad_ = writer_->loan(200);
    write_frame(*bad_, 1, 1, 100);
    header_ = iox::mepoo::ChunkHeader::fromUserPayload(bad_->data);
  }
  void TearDown() override {
    bad_.reset();
    reader_.reset();
    writer_.reset();
    ShmPorts::TearDown();
  }

  /// Finds the field of the header that the result of `read` depends on, and adds `more` to the field.
  template <class Read>
  void forge(std::uint32_t more, const Read& read) {
    std::byte* const fields = reinterpret_cast<std::byte*>(header_);
    const auto add = [&](std::size_t at, std::uint32_t number) {
      std::uint32_t value = 0;
      std::memcpy(&value, fields + at, sizeof value);
      value += number;
      std::memcpy(fields + at, &value, sizeof value);
    };
    const auto honest = read();
    for (std::size_t at = 0; at + sizeof(std::uint32_t) <= sizeof *header_; at += sizeof(std::uint32_t)) {
      add(at, 8);
      const bool found = read() == honest + 8;
      add(at, 0U - 8U);
      if (found) return add(at, more);
    }
    ADD_FAILURE() << "the header has no such field";
  }
  void forge_size(std::uint32_t more) {
    forge(more, [this] { return header_->userPayloadSize(); });
  }
  void forge_position(std::uint32_t more) {
    forge(more, [this] { return static_cast<std::byte*>(header_->userPayload()); });
  }
  void expect_refusal() {
    EXPECT_EQ(writer_->port().send(bad_), SendStatus::sent);
    EXPECT_FALSE(reader_->take());
    EXPECT_EQ(reader_->port().counters().discarded, 1U);
    EXPECT_EQ(node()->counters().malformed, 1U);
  }

  std::optional<Writer> writer_;
  std::optional<Reader> reader_;
  SampleHandle bad_;
  iox::mepoo::ChunkHeader* header_ = nullptr;
};

TEST_F(ForgedChunk, ThatReachesBeyondTheSegmentByItsHeaderIsRefused) {
  const std::uint32_t more = 0xFFFF'FFF0 - header_->userPayloadSize();
  forge_size(more);
  expect_refusal();
  forge_size(0U - more);
}

TEST_F(ForgedChunk, WhoseSampleIsNotAlignedIsRefused) {
  std::memmove(bad_->data + 4, bad_->data, frame_bytes(100));
  forge_position(4);
  expect_refusal();
  forge_position(0U - 4U);
}

/// Returns the memory at which this process has mapped the daemon's management data.
std::span<std::byte> management_memory() {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    std::uintptr_t begin = 0;
    std::uintptr_t end = 0;
    if (line.find("/dev/shm/iceoryx_mgmt") != std::string::npos &&
        std::sscanf(line.c_str(), "%zx-%zx", &begin, &end) == 2)
      return {reinterpret_cast<std::byte*>(begin), end - begin};
  }
  return {};
}

TEST_F(ForgedChunk, WhoseSampleLiesAmongTheDaemonsOwnDataIsRefused) {
  const std::span<std::byte> management = management_memory();
  ASSERT_FALSE(management.empty());
  constexpr std::size_t bytes = frame_bytes(100);
  constexpr std::size_t room = (bytes + 4095) / 4096 * 4096;
  const std::array<std::byte, room> nothing{};
  std::byte* unused = management.data() + management.size() - 2 * room;  // begins the search before the end
  while (unused > management.data() && std::memcmp(unused, nothing.data(), room) != 0) unused -= room;
  const auto distance = unused - static_cast<std::byte*>(header_->userPayload());
  if (distance < 0 || distance > 0xF000'0000) GTEST_SKIP() << "no header can point there";
  std::memcpy(unused, bad_->data, bytes);
  forge_position(static_cast<std::uint32_t>(distance));
  expect_refusal();
  forge_position(0U - static_cast<std::uint32_t>(distance));
  std::memset(unused, 0, bytes);
}

TEST_F(ShmPorts, RefuseALoanBeyondTheLimitAndCountIt) {
  Node other(no_daemon_and_held_at_most(12));
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

TEST_F(ShmPorts, RefuseALoanThatNoPoolCanHold) {
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

TEST_F(ShmPorts, NeverWriteIntoAHeldSampleAlsoIfItHadNoRoute) {
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

TEST_F(ShmPorts, GiveSamplesOnlyToReadersThatTheWriterServes) {
  Writer writer(node(), 1);
  Reader reader(node());
  ASSERT_TRUE(reader.connects_to(1));
  const auto serve = [&](core::EndpointId id) {
    writer.port().set_routes(
        {{.reader = id, .destination = core::DoorbellAddress{}, .selection = frame_type().full()}});
  };
  for (std::uint64_t round = 0; round < 3; ++round) {
    serve(reader_id + 1);
    writer.send_frame();
    EXPECT_FALSE(reader.take()) << "it is served elsewhere, and what comes here is for another reader";
    serve(reader_id);
    writer.send_frame();
    EXPECT_EQ(sequence_of(reader.take()), 2 * round + 2);
  }
  EXPECT_EQ(reader.port().counters().discarded, 0U);
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
  Node other(no_daemon_and_held_at_most(2));
  ASSERT_TRUE(other.becomes_ready()) << other->description();
  Writer writer(node(), 1);
  Reader reader(other);
  ASSERT_TRUE(reader.connects_to(1));
  for (int i = 0; i < 4; ++i) writer.send_frame();
  SampleHandle first = reader.next();
  const SampleHandle second = reader.next();
  EXPECT_FALSE(reader.take());
  EXPECT_FALSE(reader.take());
  EXPECT_EQ(reader.port().held_too_many(), 1U) << "this counts once, as long as no sample is given back";
  first.reset();
  first = reader.next();
  EXPECT_EQ(sequence_of(first), 3U);
  EXPECT_FALSE(reader.take());
  EXPECT_EQ(reader.port().held_too_many(), 2U);
}

TEST_F(ShmPorts, ReleaseSamplesOnAnyThread) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "the thread sanitizer does not see the synchronisation in iceoryx's library";
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
  writer.port().set_routes({{.reader = reader_id, .destination = address, .selection = full},
                            {.reader = 2, .destination = address, .selection = full}});
  SampleHandle got;
  std::thread sleeper(
      [&] { bell.wait(Clock::now() + 5s, [&] { return static_cast<bool>(got = reader.take()); }); });
  EXPECT_TRUE(eventually([&] { return bell.sleepers == 1; }));
  const auto before = bell.rings.load();
  writer.send_frame();
  sleeper.join();
  EXPECT_EQ(bell.rings, before + 1) << "two readers with the same doorbell must cause one ring";
  if (!got) got = reader.take();
  EXPECT_TRUE(got);
}

TEST_F(ShmPorts, KeepTheDoorbellOfAReaderOpenUntilRoutesWithoutTheReaderAreSet) {
  const auto page = core::DoorbellPage::create();
  const auto times_mapped = [path = core::DoorbellPage::path_of(page->id())] {
    std::ifstream maps("/proc/self/maps");
    int times = 0;
    for (std::string line; std::getline(maps, line);) times += line.ends_with(path) ? 1 : 0;
    return times;
  };
  Writer writer(node(), 1);
  const core::Route route{.reader = 5, .destination = core::DoorbellAddress{page->id(), 3}, .selection = {}};
  EXPECT_EQ(writer.port().why_unreachable(route), "");
  EXPECT_EQ(times_mapped(), 2) << "the page is opened once, for the routes that follow";
  writer.port().set_routes({route});
  EXPECT_EQ(times_mapped(), 2);
  writer.port().set_routes({});
  EXPECT_EQ(times_mapped(), 1);
  EXPECT_EQ(writer.port().why_unreachable(route), "");
  writer.port().set_routes({});
  EXPECT_EQ(times_mapped(), 1);
}

TEST_F(ShmPorts, DoNotBeginForALateReaderIfMoreSamplesWereHeldBackMeanwhile) {
  Writer writer(node(), 1);
  const core::Route late{.reader = 5, .destination = core::DoorbellAddress{}, .selection = {}, .history = 2};
  EXPECT_FALSE(writer.port().begin_with(late, {}, 1));
  EXPECT_TRUE(writer.port().begin_with(late, {}, 0));
}

TEST_F(ShmPorts, SendTheSampleThatALateReaderWasGivenWithTheHistoryBeforeItWasSent) {
  Writer writer(node(), 1);
  Reader early(node());
  ASSERT_TRUE(early.connects_to(1));
  Reader late(node(), 8, 5);
  ASSERT_TRUE(late.port().connect({.writer = 1, .max_sample_bytes = 1000, .history_first = true}));
  ASSERT_TRUE(eventually([&] { return late.port().connected(1); }));
  const core::Route route{.reader = 5, .destination = core::DoorbellAddress{}, .selection = {}, .history = 1};
  // A publisher adds a sample to its history before it sends the sample.
  const SampleHandle sample = writer.loan(100);
  write_frame(*sample, 1, 1, 100);
  ASSERT_TRUE(writer.port().begin_with(route, {sample}, 0));
  ASSERT_EQ(sequence_of(late.next()), 1U);
  EXPECT_TRUE(writer.port().can_send(*sample));
  EXPECT_EQ(writer.port().send(sample), SendStatus::sent);
  EXPECT_TRUE(early.next());
  EXPECT_FALSE(writer.port().can_send(*sample)) << "it has been sent";
}

TEST_F(ShmPorts, RingTheDoorbellOfALateReaderThatSleepsWhateverItsRate) {
  const auto page = core::DoorbellPage::create();
  core::Doorbell& bell = page->at(3);
  Writer writer(node(), 1);
  std::thread sleeper([&] { bell.wait(Clock::now() + 10 * hang_timeout, [&] { return bell.rings > 0; }); });
  EXPECT_TRUE(eventually([&] { return bell.sleepers == 1; }));
  core::Route late{
      .reader = 5, .destination = core::DoorbellAddress{page->id(), 3}, .selection = {}, .history = 2};
  late.gate = std::make_shared<core::Gate>(1'000'000);  // no sample has passed this gate
  const auto begin = Clock::now();
  EXPECT_TRUE(writer.port().begin_with(late, {}, 0));
  sleeper.join();
  EXPECT_LT(Clock::now() - begin, hang_timeout) << "the reader was not woken, and slept until its deadline";
}

/// A writer and a reader with a short queue.
class LostSamples : public ShmPorts {
 protected:
  static constexpr std::uint32_t depth = 4;

  void SetUp() override {
    ShmPorts::SetUp();
    if (IsSkipped()) return;
    writer_.emplace(node(), 1);
    reader_.emplace(node(), depth);
  }
  void TearDown() override {
    reader_.reset();
    writer_.reset();
    ShmPorts::TearDown();
  }

  void send(std::uint32_t count = 1) {
    for (; count > 0; --count) {
      const SampleHandle sample = writer_->loan(100);
      write_frame(*sample, 1, ++sequence_, 100);
      ASSERT_EQ(writer_->port().send(sample), SendStatus::sent);
    }
  }
  void send_and_take(std::uint32_t count = 1) {
    for (; count > 0; --count) {
      send();
      ASSERT_TRUE(reader_->take());
    }
  }
  /// Makes a gap in the sequence numbers, as samples that go to the reader by UDP do.
  void make_gap(std::uint64_t samples) { sequence_ += samples; }
  std::uint64_t counted() {
    while (reader_->take()) continue;
    return reader_->port().counters().discarded;
  }

  std::optional<Writer> writer_;
  std::optional<Reader> reader_;
  std::uint64_t sequence_ = 0;
};

TEST_F(LostSamples, AreCountedOnce) {
  ASSERT_TRUE(reader_->connects_to(1));
  send_and_take();
  send(depth + 3);
  EXPECT_EQ(counted(), 3U);
  send(depth + 2);
  EXPECT_EQ(counted(), 5U);
}

// The reader does not know the first sequence number. So the reader cannot know the number of samples that
// were lost before the first one that it takes.
TEST_F(LostSamples, CountAsOneBeforeTheFirstSampleThatIsTaken) {
  ASSERT_TRUE(reader_->connects_to(1));
  send(depth + 3);
  EXPECT_EQ(counted(), 1U);
}

// Gaps also have other reasons than lost samples. An old gap must not count when the queue loses samples long
// afterwards.
TEST_F(LostSamples, DoNotIncludeGapsOfLongAgo) {
  ASSERT_TRUE(reader_->connects_to(1));
  send_and_take();
  make_gap(1000);
  send_and_take(1 + depth + 2);
  send(depth + 3);
  EXPECT_EQ(counted(), 3U);
}

// A writer reports an overflow after it has displaced a sample. By then the reader may have taken all other
// samples of the queue.
TEST_F(LostSamples, CountAlsoIfTheOverflowIsReportedAQueueOfSamplesLater) {
  ASSERT_TRUE(reader_->connects_to(1));
  send_and_take();
  make_gap(10);
  send_and_take();
  make_gap(5);
  send_and_take(1 + depth + 1);
  send(depth + 3);
  EXPECT_EQ(counted(), 10U + 5U + 3U);
}

TEST_F(LostSamples, CountAlsoIfArrivalsNoticedTheOverflowFirst) {
  ASSERT_TRUE(reader_->connects_to(1));
  send_and_take();
  EXPECT_EQ(reader_->port().arrivals(1), 1U);
  send(depth + 3);
  EXPECT_EQ(reader_->port().arrivals(1), 1U + depth + 1U);
  send();
  EXPECT_EQ(reader_->port().arrivals(1), 1U + depth + 2U)
      << "arrivals must change also while the queue is full";
  EXPECT_EQ(reader_->port().arrivals(1), 1U + depth + 2U);
  EXPECT_EQ(counted(), 4U);
}

TEST_F(LostSamples, LeaveItOpenWhichSampleIsTheOldestOfTheHistory) {
  // The route requests no history, so the reader gets only new samples.
  writer_->port().set_routes(
      {{.reader = 7, .destination = core::DoorbellAddress{}, .selection = frame_type().full()}});
  for (const std::uint32_t lost : {0U, 1U}) {
    reader_.emplace(node(), depth);
    ASSERT_TRUE(reader_->port().connect({.writer = 1, .max_sample_bytes = 1000, .history_first = true}));
    ASSERT_TRUE(eventually([&] { return reader_->port().connected(1); }));
    send(depth + lost);
    const SampleHandle first = reader_->take();
    ASSERT_TRUE(first);
    EXPECT_EQ(first->oldest_retained, lost == 0 ? first->sequence : 0U);
    EXPECT_EQ(reader_->take()->oldest_retained, 0U);
  }
}

TEST_F(ShmPorts, OfTwoNodesInOneProcessWorkSideBySide) {
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
