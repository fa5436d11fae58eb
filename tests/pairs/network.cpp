#include "tests/pairs/network.h"

#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace sft::test {

namespace {

constexpr const char* tap_control = "/dev/net/tun";
constexpr std::size_t frame_bytes_max = 2048, frame_header_bytes = 14;
constexpr std::chrono::microseconds delay_max{20'000};

/// Returns one of the two addresses at the beginning of a frame: the destination (place 0) or the source
/// (place 1).
std::array<char, 6> address_at(std::size_t place, const std::vector<char>& frame) {
  std::array<char, 6> address{};
  std::copy_n(frame.begin() + static_cast<std::ptrdiff_t>(place * address.size()), address.size(),
              address.begin());
  return address;
}
std::array<char, 6> destination_of(const std::vector<char>& frame) { return address_at(0, frame); }
std::array<char, 6> source_of(const std::vector<char>& frame) { return address_at(1, frame); }
bool is_multicast(const std::vector<char>& frame) { return (frame[0] & 1) != 0; }

}  // namespace

std::string Network::refusal() {
  const int control = open(tap_control, O_RDWR | O_CLOEXEC);
  if (control < 0) return std::string(tap_control) + ": " + std::strerror(errno);
  close(control);
  return {};
}

Network::Network(std::uint64_t seed)
    : wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)), random_(seed), thread_([this] { run(); }) {}

Network::~Network() {
  ended_ = true;
  wake();
  thread_.join();
  for (const Port& port : ports_) close(port.tap);
  close(wake_);
}

std::size_t Network::plug_in() {
  const int tap = open(tap_control, O_RDWR | O_CLOEXEC | O_NONBLOCK);
  ifreq request{};
  request.ifr_flags = IFF_TAP | IFF_NO_PI;
  std::strcpy(request.ifr_name, "eth0");
  if (tap < 0 || ioctl(tap, TUNSETIFF, &request) != 0)
    throw std::system_error(errno, std::generic_category(), tap_control);
  const std::scoped_lock lock(mutex_);
  ports_.push_back({tap});
  wake();
  return ports_.size() - 1;
}

void Network::set_plugged(std::size_t port, bool plugged) {
  const std::scoped_lock lock(mutex_);
  ports_[port].plugged = plugged;
  const int carrier = plugged ? 1 : 0;
  ioctl(ports_[port].tap, TUNSETCARRIER, &carrier);
}

void Network::set_faults(const Faults& faults) {
  const std::scoped_lock lock(mutex_);
  faults_ = faults;
}

void Network::wake() const {
  const std::uint64_t one = 1;
  (void)!write(wake_, &one, sizeof one);
}

void Network::run() {
  while (!ended_) {
    std::vector<pollfd> watched{{.fd = wake_, .events = POLLIN, .revents = 0}};
    int timeout_ms = -1;
    {
      const std::scoped_lock lock(mutex_);
      for (const Port& port : ports_) watched.push_back({.fd = port.tap, .events = POLLIN, .revents = 0});
      timeout_ms = until_next_delayed_ms();
    }
    if (poll(watched.data(), watched.size(), timeout_ms) < 0) continue;
    const std::scoped_lock lock(mutex_);
    std::uint64_t woken = 0;
    (void)!read(wake_, &woken, sizeof woken);
    for (std::size_t i = 1; i < watched.size(); ++i) {
      if ((watched[i].revents & POLLIN) != 0) receive(i - 1);
    }
    deliver_delayed();
  }
}

void Network::receive(std::size_t from) {
  Frame frame(frame_bytes_max);
  for (;;) {
    const ssize_t bytes = read(ports_[from].tap, frame.data(), frame_bytes_max);
    if (bytes <= 0) return;
    ++frames_;
    if (static_cast<std::size_t>(bytes) < frame_header_bytes) continue;
    port_of_[source_of(frame)] = from;
    judge(from, Frame(frame.begin(), frame.begin() + bytes));
  }
}

void Network::judge(std::size_t from, const Frame& frame) {
  const int copies = happens(faults_.repeated) ? 2 : 1;
  for (int i = 0; i < copies; ++i) {
    if (happens(faults_.lost)) continue;
    if (!happens(faults_.delayed)) {
      deliver(from, frame);
      continue;
    }
    const std::chrono::microseconds delay(1 + random_() % static_cast<std::uint64_t>(delay_max.count()));
    delayed_.insert({Clock::now() + delay, {from, frame}});
  }
}

/// Returns true if the frame has to go to that port. A frame for one host goes to all ports only until the
/// port of that host is known. If each frame went to many hosts, the forwarding thread would be slower than a
/// publisher, and frames would be lost before the thread reads them.
bool Network::is_for(std::size_t port, const Frame& frame) const {
  if (is_multicast(frame)) return true;
  const auto known = port_of_.find(destination_of(frame));
  return known == port_of_.end() || known->second == port;
}

void Network::deliver(std::size_t from, const Frame& frame) {
  if (!ports_[from].plugged) return;
  for (std::size_t to = 0; to < ports_.size(); ++to) {
    if (to != from && ports_[to].plugged && is_for(to, frame))
      (void)!write(ports_[to].tap, frame.data(), frame.size());
  }
}

void Network::deliver_delayed() {
  const auto due = delayed_.upper_bound(Clock::now());
  for (auto i = delayed_.begin(); i != due; ++i) deliver(i->second.from, i->second.frame);
  delayed_.erase(delayed_.begin(), due);
}

int Network::until_next_delayed_ms() const {
  if (delayed_.empty()) return -1;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(delayed_.begin()->first - Clock::now());
  return std::max(0, static_cast<int>(left.count()));
}

bool Network::happens(double probability) {
  return probability > 0 && std::uniform_real_distribution<>(0, 1)(random_) < probability;
}

}  // namespace sft::test
