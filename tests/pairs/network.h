// A network in user space. Each host's eth0 is a tap device. A thread forwards frames between these devices,
// with the faults that are set. Like a switch, the network forwards a frame for one host to that host only.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace sft::test {

/// The probabilities of the faults of a frame.
struct Faults {
  double lost = 0;
  double repeated = 0;
  double delayed = 0;  ///< probability of a delay of up to 20 ms, so that later frames overtake the frame
};

class Network {
 public:
  explicit Network(std::uint64_t seed);
  ~Network();
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  /// Returns the reason why no network can be made, or "" if one can be made.
  static std::string refusal();

  /// Makes eth0 in the network namespace of the calling thread. Returns the number of its port.
  std::size_t plug_in();
  /// Plugs or unplugs the cable at a port. An unplugged cable carries no frames, and the host sees that its
  /// cable is unplugged.
  void set_plugged(std::size_t port, bool plugged);
  void set_faults(const Faults& faults);
  /// Returns the number of frames that all hosts have sent so far.
  std::uint64_t frames() const { return frames_; }

 private:
  using Clock = std::chrono::steady_clock;
  using Frame = std::vector<char>;
  struct Port {
    int tap = -1;
    bool plugged = true;
  };
  struct Passing {
    std::size_t from;
    Frame frame;
  };

  void run();
  void receive(std::size_t from);
  bool is_for(std::size_t port, const Frame& frame) const;
  void judge(std::size_t from, const Frame& frame);
  void deliver(std::size_t from, const Frame& frame);
  void deliver_delayed();
  int until_next_delayed_ms() const;
  bool happens(double probability);
  void wake() const;

  const int wake_;
  std::mutex mutex_;
  std::vector<Port> ports_;
  std::map<std::array<char, 6>, std::size_t> port_of_;  ///< the port of each address that has sent a frame
  Faults faults_;
  std::mt19937_64 random_;
  std::multimap<Clock::time_point, Passing> delayed_;
  std::atomic<std::uint64_t> frames_{0};
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

}  // namespace sft::test
