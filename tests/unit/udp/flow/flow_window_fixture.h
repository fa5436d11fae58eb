// A flow window, a sender that always has more data to send, and a receiver that answers the sender's flow
// marks.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "udp_transport/flow/flow_window.h"

namespace sft::udp::test {

using namespace std::chrono_literals;
using Size = FlowWindow::Size;

inline constexpr std::uint32_t flow = 7;
inline constexpr std::size_t batch_datagrams = 10, batch_bytes = 14'720;

class FlowWindowTest : public testing::Test {
 protected:
  /// Sends like the sending thread while the window allows it, up to `at_most` bytes. Returns the number of
  /// sent socket bytes.
  std::size_t send_while_there_is_room(Size size = Size::large, std::size_t at_most = SIZE_MAX) {
    const std::uint64_t before = window.position();
    while (window.position() - before < at_most && window.room(size, now) > 0) {
      window.sent(batch_bytes, batch_datagrams, now);
      take_mark();
    }
    take_mark();
    return window.position() - before;
  }
  void take_mark() {
    if (const auto mark = window.mark(now)) marks.push_back(*mark);
  }
  /// Sends. Then the receiver answers for the first time, with that share of its receive buffer.
  void get_to_know(std::size_t share) {
    send_while_there_is_room();
    ASSERT_TRUE(answer(share));
  }
  /// Sends until `end`, whenever the window allows it. No flow mark is answered. Returns the number of sent
  /// bytes.
  std::size_t send_until(FlowWindow::Time end, Size size = Size::large) {
    std::size_t sent = 0;
    for (; now < end; now = window.next_ready(now) + 1us) sent += send_while_there_is_room(size);
    return sent;
  }
  FlowReport report(const FlowMark& mark, std::size_t share) const {
    return {.flow = flow,
            .position = mark.position,
            .window_bytes = static_cast<std::uint32_t>(share),
            .datagrams = mark.datagrams,
            .came = mark.datagrams,
            .sent_at_ns = mark.sent_at_ns};
  }
  /// Answers all flow marks after the time `after`. Returns true if a sender that waited may continue.
  bool answer(std::size_t share, std::chrono::microseconds after = 100us) {
    now += after;
    bool goes_on = false;
    for (const FlowMark& mark : std::exchange(marks, {}))
      goes_on = window.hear(report(mark, share), now) || goes_on;
    return goes_on;
  }

  /// Sends for the time `time`. The receiver takes `bytes_per_ms`, and answers each flow mark when it has
  /// taken all bytes that were sent before the mark.
  void take_for(FlowWindow::Time::duration time, std::uint64_t bytes_per_ms, std::size_t share = 32 << 20) {
    for (const auto end = now + time; now < end;) {
      send_while_there_is_room();
      ASSERT_FALSE(marks.empty());
      take_one(bytes_per_ms, share);
    }
  }
  void take_one(std::uint64_t bytes_per_ms, std::size_t share = 32 << 20) {
    const FlowMark next = marks.front();
    marks.erase(marks.begin());
    now += 50us + std::chrono::nanoseconds(1'000'000 * (next.position - taken) / bytes_per_ms);
    taken = next.position;
    (void)window.hear(report(next, share), now);
  }

  FlowWindow::Time now{1h};
  std::vector<FlowMark> marks;
  std::uint64_t taken = 0;
  FlowWindow window{flow, FlowLimits{}};
};

}  // namespace sft::udp::test
