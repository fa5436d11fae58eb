#include "bench/negotiation/response.h"

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <thread>
#include <utility>

#include "bench/common/statistics.h"
#include "bench/negotiation/negotiation.h"
#include "core/discovery/dds_config.h"

namespace sft::bench {

namespace {

struct HeightProbe {
  using Message = sensor_msgs::msg::PointCloud2;
  static constexpr auto wanted = Message::Field::height;
  static void read_usual(const auto& sample) { (void)sample->width(); }
  static void read_wanted(const auto& sample) { (void)sample->height(); }
};

/// The timeout for the last messages, which usually arrive within a millisecond.
constexpr std::int64_t arriving_ns = 1'000'000'000;

using Act = std::function<void(std::uint64_t)>;

const Topic requests{.name = "requests", .durable = true};

/// Calls `act` for each given number on a separate thread, like the agent of a node.
class Helper {
 public:
  explicit Helper(Act act) : act_(std::move(act)), thread_([this] { run(); }) {}
  ~Helper() { give(0); }
  Helper(const Helper&) = delete;
  Helper& operator=(const Helper&) = delete;

  /// Passes a number to the thread; 0 ends the thread.
  void give(std::uint64_t number) {
    {
      const std::lock_guard lock(mutex_);
      given_.push_back(number);
    }
    changed_.notify_one();
  }

 private:
  void run() {
    for (;;) {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return !given_.empty(); });
      const std::uint64_t number = given_.front();
      given_.pop_front();
      lock.unlock();
      if (number == 0) return;
      act_(number);
    }
  }

  const Act act_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::uint64_t> given_;
  std::jthread thread_;
};

/// The thread that writes on one side, and the thread that notes arrivals on the other side.
enum class By { the_thread_itself, a_helper };

void write(Exchange& exchange, std::uint64_t messages, By by) {
  const auto peer = cyclone_control_peer();
  const auto writer = peer->writer(requests);
  const Act act = [&](std::uint64_t number) { writer->write(number); };
  std::optional<Helper> helper;
  if (by == By::a_helper) helper.emplace(act);
  while (!exchange.ready.load() || writer->readers() == 0) sleep_us(1000);
  for (std::uint64_t i = 0; i < messages; ++i) {
    sleep_us(1000);
    exchange.sent_at[i] = now_ns();
    helper ? helper->give(i + 1) : act(i + 1);
  }
  const std::int64_t end = now_ns() + arriving_ns;
  while (exchange.received.load() < messages && now_ns() < end) sleep_us(1000);
}

void listen(Exchange& exchange, std::uint64_t messages, By by) {
  const Act note = [&](std::uint64_t number) {
    exchange.received_at[number - 1] = now_ns();
    exchange.received.store(number, std::memory_order_release);
  };
  std::optional<Helper> helper;
  if (by == By::a_helper) helper.emplace(note);
  const Arrived arrived = [&](std::uint64_t number) { helper ? helper->give(number) : note(number); };
  const auto peer = cyclone_control_peer();
  const auto reader = peer->reader(requests, arrived);
  exchange.ready = true;
  while (exchange.received.load() < messages && !exchange.failed.load()) sleep_us(1000);
}

std::vector<double> dds_write_times(const TwoHosts& hosts, std::uint64_t messages, By by) {
  return run_pair(hosts.sides([=](Exchange& e) { write(e, messages, by); },
                              [=](Exchange& e) { listen(e, messages, by); }),
                  messages);
}

}  // namespace

std::unique_ptr<Peer> cyclone_control_peer() {
  return cyclone_peer_with(core::dds_config(0, {}, "").value().text);
}

std::vector<double> dds_write_times(const TwoHosts& hosts, std::uint64_t messages) {
  return dds_write_times(hosts, messages, By::the_thread_itself);
}

std::vector<Figure> str_response(const Scale& scale) {
  const TwoHosts hosts;
  Rounds ours, raw, by_helpers;
  for (int round = 0; round < scale.rounds; ++round) {
    ours.add(response_times<HeightProbe>(hosts, scale.messages));
    raw.add(dds_write_times(hosts, scale.messages));
    by_helpers.add(dds_write_times(hosts, scale.messages, By::a_helper));
  }
  const char* reference = "dds_write to a listener";
  // This path is measured, too, because a node leaves requests to its agent: neither a getter nor a
  // listener of Cyclone DDS may block.
  const char* floor = "the same, from one helping thread to another";
  return {{"str_response", ours.p50(), "us", raw.p50(), reference, 100, true},
          {"str_response_ratio", ours.p50(), "us", raw.p50(), reference, 1.3},
          {"str_response_p99", ours.p99(), "us", raw.p99(), reference, 1000, true},
          {"str_response_over_helpers", ours.p50(), "us", by_helpers.p50(), floor, {}}};
}

}  // namespace sft::bench
