// A writer never waits for a reader that stands still during a take, at any instruction. Nor does a reader
// wait for a writer that stands still during a send. The other process may have been killed there, be stopped
// by a debugger, or have a lower priority.
#include <gtest/gtest.h>

#include <functional>
#include <future>
#include <set>

#include "tests/transports/shm/shm_fixture.h"
#include "tests/transports/shm/stepped_peer.h"

namespace sft::test {
namespace {

using core::SampleHandle;
using core::SendStatus;

constexpr std::uint32_t frame = 100;

/// The number of the peer's steps between two calls of the test. With more calls the peer would make no
/// progress, because iceoryx's lists of free chunks make the peer try again whenever another process has
/// changed the list.
constexpr int steps_between_stops = 128;
constexpr int stops_at_an_instruction = 3;  // stops at the same instruction, if it is in a loop

class StoppedPeer : public ShmNodeTest {
 protected:
  void SetUp() override {
    ShmNodeTest::SetUp();
    if (!SteppedPeer::has_breakpoints) GTEST_SKIP() << "needs breakpoints of an x86 processor";
  }

  /// Lets the peer do its work repeatedly, and stops it at each instruction of the work. At each stop calls
  /// `act` in another thread, and expects `act` to return before the peer continues. Returns the number of
  /// instructions at which the peer was stopped.
  static std::size_t at_each_instruction(const Process& process, const std::function<void()>& act) {
    const SteppedPeer peer(process);
    std::size_t stopped_at = 0;
    for (const std::uintptr_t instruction : instructions_of_its_work(peer, act)) {
      act();
      if (!peer.goes_to_mark()) break;
      peer.set_breakpoint(instruction);
      int stops = 0;
      for (; stops < stops_at_an_instruction && peer.goes_to_breakpoint(); ++stops) {
        if (!returns_while_the_peer_stands_still(peer, act)) return 0;
      }
      peer.clear_breakpoint();
      if (stops == stops_at_an_instruction && !peer.goes_to_mark()) break;
      stopped_at += stops > 0;
    }
    return stopped_at;
  }

 private:
  /// Returns the addresses of the instructions of the peer's work. Steps through the work twice. The second
  /// time calls `act` now and then, so that the peer also executes the instructions of a retry.
  static std::set<std::uintptr_t> instructions_of_its_work(const SteppedPeer& peer,
                                                           const std::function<void()>& act) {
    std::set<std::uintptr_t> instructions;
    for (const bool disturbed : {false, true}) {
      if (!peer.goes_to_mark()) return {};
      for (int step = 1; peer.steps(); ++step) {
        instructions.insert(peer.instruction());
        if (disturbed && step % steps_between_stops == 0 && !returns_while_the_peer_stands_still(peer, act))
          return {};
      }
    }
    return instructions;
  }

  static bool returns_while_the_peer_stands_still(const SteppedPeer& peer, const std::function<void()>& act) {
    const auto done = std::async(std::launch::async, act);
    if (done.wait_for(hang_timeout) == std::future_status::ready) return true;
    ADD_FAILURE() << "blocked by a peer that stands still at instruction " << peer.instruction();
    peer.clear_breakpoint();
    if (!peer.goes_to_mark()) ADD_FAILURE() << "the peer has ended";
    return false;  // the destructor of the future waits for the end of the call
  }
};

class StoppedReader : public StoppedPeer {
 protected:
  void blocks_no_writer(int depth) {
    Writer writer(node(), 1);
    Process process = start_peer({"take-by-steps", "1", std::to_string(depth)});
    ASSERT_EQ(process.line(), "subscribed");
    ASSERT_TRUE(SteppedPeer(process).comes_to_mark());
    for (int i = 0; i < depth; ++i) ASSERT_EQ(writer.send_frame(frame), SendStatus::sent);
    const std::size_t stops = at_each_instruction(process, [&] {
      for (int i = 0; i < 4; ++i) ASSERT_EQ(writer.send_frame(frame), SendStatus::sent);
    });
    EXPECT_GT(stops, 100U);
  }
};

TEST_F(StoppedReader, BlocksNoWriterAtAnyInstructionOfATake) { blocks_no_writer(1); }
TEST_F(StoppedReader, OfADeepestQueueBlocksNoWriterAtAnyInstructionOfATake) { blocks_no_writer(256); }

using StoppedWriter = StoppedPeer;
TEST_F(StoppedWriter, BlocksNoReaderAtAnyInstructionOfASend) {
  Reader reader(node(), 2);
  Process process = start_peer({"send-by-steps", "1", std::to_string(frame)});
  ASSERT_EQ(process.line(), "publishing");
  ASSERT_TRUE(SteppedPeer(process).comes_to_mark());
  ASSERT_TRUE(reader.connects_to(1));
  std::uint64_t taken = 0;
  const std::size_t stops = at_each_instruction(process, [&] {
    while (reader.take()) ++taken;
  });
  EXPECT_GT(stops, 100U);
  EXPECT_GT(taken, 100U);
}

}  // namespace
}  // namespace sft::test
