// Several processes send to one socket as fast as they may. The socket's buffer does not overflow, each
// sender gets its share, and no sender stops for ever, whichever datagrams are lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/simulation/udp/random.h"
#include "tests/support/test_seed.h"
#include "udp_transport/flow/flow_window.h"
#include "udp_transport/flow/receive_shares.h"

namespace sft::simulation {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t buffer_bytes = 212'992;
constexpr std::size_t train_datagrams = 4, train_bytes = 4 * 1472;
constexpr auto tick = 20us;

struct Train {
  std::size_t sender = 0;
  std::optional<udp::FlowMark> mark{};  ///< if set, this is a mark instead of a train
  std::size_t cost() const {
    return mark ? udp::socket_bytes(0, 1) : udp::socket_bytes(train_bytes, train_datagrams);
  }
};

class SharedSocket {
 public:
  SharedSocket(std::uint64_t seed, double loss) : random_(seed), loss_(loss) {
    for (std::size_t i = 0; i < from_to(random_, 1, 6); ++i)
      senders_.emplace_back(static_cast<std::uint32_t>(i));
    delay_ = from_to(random_, 1, 20);
    taken_per_tick_ = from_to(random_, 1, 6);
  }

  void run(std::chrono::milliseconds time) {
    for (const Time end = now_ + time; now_ < end; now_ += tick) {
      for (std::size_t i = 0; i < senders_.size(); ++i) send(i);
      arrive();
      take();
      hear();
    }
  }
  /// Runs until each sender has received an answer, because a sender may send very little before. Returns
  /// false if that takes longer than `at_most`.
  bool run_until_all_are_answered(std::chrono::milliseconds at_most) {
    const auto answered = [this](const Sender& sender) { return sender.window.answers(now_); };
    for (const Time end = now_ + at_most; !std::ranges::all_of(senders_, answered);) {
      if (now_ >= end) return false;
      run(10ms);
    }
    return true;
  }
  void stop(std::size_t sender) { senders_[sender].stopped = true; }
  void forget_counts() {
    for (Sender& sender : senders_) sender.came = 0;
  }

  std::size_t senders() const { return senders_.size(); }
  std::uint64_t came(std::size_t sender) const { return senders_[sender].came; }
  std::uint64_t dropped() const { return dropped_; }
  std::uint64_t could_take(std::chrono::milliseconds time) const {
    // Half as much as without pauses of the receiver.
    return static_cast<std::uint64_t>(time / tick) * taken_per_tick_ / 2;
  }

 private:
  struct Sender {
    explicit Sender(std::uint32_t number) : window(number, udp::FlowLimits{}) {}
    udp::FlowWindow window;
    std::uint64_t came = 0;
    bool stopped = false;
  };
  template <class T>
  using Line = std::deque<std::pair<Time, T>>;

  void send(std::size_t number) {
    Sender& sender = senders_[number];
    for (int i = 0; i < 8 && !sender.stopped; ++i) {
      if (sender.window.room(udp::FlowWindow::Size::large, now_) == 0) break;
      sender.window.sent(train_bytes, train_datagrams, now_);
      put({number});
    }
    if (const auto mark = sender.window.mark(now_)) put({number, mark});
  }
  void put(const Train& train) {
    if (!happens(random_, loss_)) on_the_way_.emplace_back(now_ + delay_ * tick, train);
  }
  void arrive() {
    for (; !on_the_way_.empty() && on_the_way_.front().first <= now_; on_the_way_.pop_front()) {
      const Train& train = on_the_way_.front().second;
      if (used_ + train.cost() > buffer_bytes) {
        ++dropped_;
      } else {
        used_ += train.cost();
        in_the_buffer_.push_back(train);
      }
    }
  }
  /// Takes trains and marks from the buffer. Sometimes the receiver does not run for a while.
  void take() {
    if (now_ < runs_again_at_) return;
    if (happens(random_, 0.002))
      runs_again_at_ = now_ + std::chrono::microseconds(from_to(random_, 100, 4000));
    for (std::size_t i = 0; i < taken_per_tick_ && !in_the_buffer_.empty(); in_the_buffer_.pop_front()) {
      const Train& train = in_the_buffer_.front();
      used_ -= train.cost();
      const udp::SocketAddress from{1U, static_cast<std::uint16_t>(train.sender)};
      if (train.mark) {
        if (!happens(random_, loss_))
          reports_.emplace_back(now_ + delay_ * tick, shares_.answer(*train.mark, from, now_));
        continue;
      }
      for (std::size_t n = 0; n < train_datagrams; ++n) shares_.count(from);
      ++senders_[train.sender].came;
      ++i;
    }
  }
  void hear() {
    for (; !reports_.empty() && reports_.front().first <= now_; reports_.pop_front())
      (void)senders_[reports_.front().second.flow].window.hear(reports_.front().second, now_);
  }

  Random random_;
  const double loss_;
  Time now_{1h};
  Time runs_again_at_{};
  std::vector<Sender> senders_;
  udp::ReceiveShares shares_{buffer_bytes};
  std::size_t delay_ = 1;
  std::size_t taken_per_tick_ = 1;
  Line<Train> on_the_way_;
  std::deque<Train> in_the_buffer_;
  std::size_t used_ = 0;
  Line<udp::FlowReport> reports_;
  std::uint64_t dropped_ = 0;
};

class SharedSocketTest : public testing::Test {
 protected:
  template <class Check>
  void for_each_seed(double loss, const Check& check) {
    const std::uint64_t first = test::test_seed();
    for (std::uint64_t seed = first; seed < first + 100 && !HasFailure(); ++seed) {
      SCOPED_TRACE("SFT_TEST_SEED=" + std::to_string(seed));
      SharedSocket socket(seed, loss);
      socket.run(100ms);
      check(socket);
    }
  }
};

TEST_F(SharedSocketTest, HoldsWhatComesFromThoseThatItKnowsAndServesThemAlike) {
  for_each_seed(0, [](SharedSocket& socket) {
    const std::uint64_t at_first = socket.dropped();
    socket.forget_counts();
    socket.run(400ms);
    EXPECT_EQ(socket.dropped(), at_first);
    std::uint64_t least = UINT64_MAX, most = 0;
    for (std::size_t i = 0; i < socket.senders(); ++i) {
      least = std::min(least, socket.came(i));
      most = std::max(most, socket.came(i));
    }
    EXPECT_GT(2 * least, most) << "of " << socket.senders();
  });
}

TEST_F(SharedSocketTest, GivesToOthersWhatOneThatStoppedDoesNotNeed) {
  for_each_seed(0, [](SharedSocket& socket) {
    for (std::size_t i = 1; i < socket.senders(); ++i) socket.stop(i);
    socket.run(600ms);
    socket.forget_counts();
    socket.run(200ms);
    EXPECT_GT(socket.came(0), std::min<std::uint64_t>(socket.could_take(200ms) / 2, 1500));
  });
}

TEST_F(SharedSocketTest, GoesOnWhateverGetsLost) {
  for (const auto& [loss, least] : {std::pair(0.2, 50U), std::pair(0.3, 10U)}) {
    SCOPED_TRACE(loss);
    for_each_seed(loss, [least = least](SharedSocket& socket) {
      ASSERT_TRUE(socket.run_until_all_are_answered(5s));
      socket.forget_counts();
      socket.run(500ms);
      for (std::size_t i = 0; i < socket.senders(); ++i) EXPECT_GT(socket.came(i), least);
    });
  }
}

}  // namespace
}  // namespace sft::simulation
