// These tests check that honest streams recover within a second after the last hostile datagram.
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "tests/support/parse_datagram.h"
#include "tests/support/test_seed.h"
#include "tests/unit/udp/live_streams.h"
#include "tests/unit/udp/mutations.h"

namespace sft::udp::test {
namespace {

using namespace std::chrono_literals;

class WorksAgainTest : public sft::test::RandomTest {
 protected:
  using Time = LiveStreams::Time;

  void run_for(
      std::chrono::milliseconds time, const std::function<void()>& between = [] {}) {
    for (const Time end = streams.now() + time; streams.now() < end;) streams.pass_a_millisecond(between);
  }
  Bytes any_captured() { return streams.captured()[random() % streams.captured().size()]; }

  /// Expects a new sample of each stream within a second, and 90 % of the samples in the second after that.
  void expect_that_all_flow_again() {
    const Time quiet = streams.now();
    run_for(1s);
    for (const StreamKind kind : all_stream_kinds)
      EXPECT_GT(streams.came_since(kind, quiet), 0U) << streams.describe(kind) << " is silent after a second";
    const Time again = streams.now();
    run_for(1s);
    const std::size_t published = 1s / LiveStreams::period;
    for (const StreamKind kind : all_stream_kinds)
      EXPECT_GE(streams.came_since(kind, again), published * 9 / 10) << streams.describe(kind);
  }

  LiveStreams streams;
};

TEST_F(WorksAgainTest, StreamsFlowWithoutLossWhereNothingHappens) {
  run_for(2s);
  for (const StreamKind kind : all_stream_kinds) {
    EXPECT_EQ(streams.harmed(kind), 0U) << name_of(kind);
    EXPECT_EQ(streams.lost(kind), 0U) << name_of(kind);
    EXPECT_GE(streams.came_since(kind, Time{}), std::size_t{2s / LiveStreams::period} - 1) << name_of(kind);
  }
}

TEST_F(WorksAgainTest, EveryStreamAfterAHundredThousandMutatedDatagrams) {
  run_for(500ms);
  std::size_t left = 100'000;
  const auto disturb = [&] {
    for (std::size_t i = 0; i < 50 && left > 0; ++i, --left) {
      Bytes datagram = any_captured();
      mutate(datagram, random);
      streams.receive(datagram);
    }
  };
  while (left > 0) run_for(1ms, disturb);
  expect_that_all_flow_again();
}

/// Only a few datagrams are damaged, so that a later one does not undo the effect of an earlier one.
TEST_F(WorksAgainTest, EveryStreamAfterAFewMutatedDatagrams) {
  for (int round = 0; round < 10 && !HasFailure(); ++round) {
    run_for(100ms);
    for (int i = 0; i < 20; ++i) {
      Bytes datagram = any_captured();
      mutate(datagram, random);
      streams.receive(datagram);
    }
    expect_that_all_flow_again();
  }
}

/// Whole datagrams have only the low 11 bits of a channel's number, so they cannot disprove a number that is
/// wrong in a higher bit.
TEST_F(WorksAgainTest, EveryStreamAfterHeartbeatsWithAWrongBitInTheirChannel) {
  run_for(500ms);
  for (const unsigned bit : {0U, 10U, 11U, 24U, 31U}) {
    for (Bytes datagram : std::vector(streams.captured())) {
      const auto heartbeat = parse_as<Heartbeat>(datagram);
      if (!heartbeat) continue;
      const Heartbeat wrong{heartbeat->writer, heartbeat->channel ^ 1U << bit, heartbeat->port, 1, 10, 0};
      encode(wrong, datagram.data());
      for (int i = 0; i < 2; ++i) streams.receive(datagram);
    }
    expect_that_all_flow_again();
    if (HasFailure()) FAIL() << "after bit " << bit;
  }
}

/// Writes each large number at each offset of random datagrams. Each datagram arrives twice, so that the
/// second one confirms the first one.
TEST_F(WorksAgainTest, EveryStreamAfterLargeNumbersInAnyFieldOfAnyKind) {
  run_for(500ms);
  for (const std::uint64_t value :
       {std::uint64_t{1} << 62, std::uint64_t{1} << 31, (std::uint64_t{1} << 16) - 1}) {
    for (std::size_t at = 2; at < 64; at += 4) {
      for (int i = 0; i < 20; ++i) {
        Bytes datagram = any_captured();
        for (std::size_t byte = 0; byte < 8 && at + byte < datagram.size(); ++byte)
          datagram[at + byte] = static_cast<std::byte>(value >> (8 * byte));
        streams.receive(datagram);
        streams.receive(datagram);
      }
      run_for(5ms);
    }
    expect_that_all_flow_again();
  }
}

}  // namespace
}  // namespace sft::udp::test
