// A writer never waits for a reader that stands still in the midst of a take, nor a reader for a writer that
// stands still in the midst of a send: at no instruction. The other one may have been killed there, or be
// stopped by a debugger, or be of a lower priority.
#include <gtest/gtest.h>
#include <sched.h>

#include <functional>
#include <future>

#include "tests/transports/shm/shm_fixture.h"
#include "tests/transports/shm/stepped_peer.h"

namespace sft::test {
namespace {

using core::SampleHandle;
using core::SendStatus;

constexpr std::uint32_t frame = 100;
constexpr std::chrono::seconds longest_call{10};

/// The peer stands still at each so many instructions of its work. The first one is another one each time, so
/// that each instruction has its turn. A peer that was disturbed more often would not get on: the lists of
/// free chunks of iceoryx make it try again whenever another process has used them meanwhile.
constexpr int steps_between_stops = 128;

class StoppedPeer : public ShmNodeTest {
 protected:
  /// A step costs four times as much if the two processes have to wake each other on different processors.
  StoppedPeer() {
    sched_getaffinity(0, sizeof before_, &before_);
    cpu_set_t one{};
    CPU_SET(static_cast<std::size_t>(sched_getcpu()), &one);
    sched_setaffinity(0, sizeof one, &one);
  }
  ~StoppedPeer() override { sched_setaffinity(0, sizeof before_, &before_); }

  /// Lets the peer do its work again and again. Calls `act` wherever the peer stands still, in another
  /// thread. Expects that each call returns before the peer goes on. Returns how often it was called.
  static int at_each_instruction(const Process& process, const std::function<void()>& act) {
    const SteppedPeer peer(process);
    int stops = 0;
    for (int first = 0; first < steps_between_stops && peer.goes_to_mark(); ++first) {
      for (int step = 0; peer.steps(); ++step) {
        if (step % steps_between_stops != first) continue;
        ++stops;
        const auto done = std::async(std::launch::async, act);
        if (done.wait_for(longest_call) == std::future_status::ready) continue;
        ADD_FAILURE() << "blocked by a peer that stands still at instruction " << step;
        if (!peer.goes_to_mark()) ADD_FAILURE() << "the peer has ended";
        return 0;  // the future waits for the end of the call
      }
    }
    return stops;
  }

 private:
  cpu_set_t before_{};
};

class StoppedReader : public StoppedPeer {
 protected:
  void blocks_no_writer(int depth) {
    Writer writer(node(), 1);
    Process process = start_peer({"take-by-steps", "1", std::to_string(depth)});
    ASSERT_EQ(process.line(), "subscribed");
    ASSERT_TRUE(SteppedPeer(process).comes_to_mark());
    for (int i = 0; i < depth; ++i) ASSERT_EQ(writer.send_frame(frame), SendStatus::sent);
    const int stops = at_each_instruction(process, [&] {
      for (int i = 0; i < 4; ++i) ASSERT_EQ(writer.send_frame(frame), SendStatus::sent);
    });
    EXPECT_GT(stops, 100);
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
  const int stops = at_each_instruction(process, [&] {
    while (reader.take()) ++taken;
  });
  EXPECT_GT(stops, 100);
  EXPECT_GT(taken, 100U);
}

}  // namespace
}  // namespace sft::test
