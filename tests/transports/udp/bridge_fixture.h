// A publisher and readers, connected by a bridge that the test makes. Each reader is on a host of its own.
#pragma once

#include <gtest/gtest.h>
#include <ifaddrs.h>
#include <linux/if_link.h>
#include <sys/socket.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/isolated_host.h"
#include "tests/transports/udp/another_host.h"
#include "tests/transports/udp/endpoints.h"
#include "udp_transport/udp_transport.h"

namespace sft::udp::test {

/// The bytes that an interface of this host has sent and received. These counters wrap around.
struct Traffic {
  std::uint32_t sent = 0, received = 0;
};
inline Traffic traffic_of(const std::string& interface) {
  Traffic traffic;
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return traffic;
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    if (i->ifa_addr == nullptr || i->ifa_addr->sa_family != AF_PACKET || i->ifa_name != interface) continue;
    const auto* counters = static_cast<const rtnl_link_stats*>(i->ifa_data);
    traffic = {counters->tx_bytes, counters->rx_bytes};
  }
  ::freeifaddrs(list);
  return traffic;
}

/// The bridge is named "bridge". Its port "port`n`" leads to the host with the address 10.20.0.`n`.
class BridgeTest : public testing::Test {
 protected:
  struct Host {
    std::unique_ptr<core::Network> transport;
    std::unique_ptr<Subscriber> subscriber;
    core::UdpAddress address;
    std::string mask;
    bool reliable = false;
    std::uint32_t since = 0;  ///< the number of samples that were published before the host was served
  };

  void TearDown() override {
    hosts_.clear();
    for (const std::string& link : links_)
      run("ip link delete " + link + " 2> /dev/null");  // the link may have disappeared with its host
  }

  /// Opens the publisher on this host.
  void open_publisher(const UdpOptions& options = {}) {
    writer_ = open_udp_transport(options, make_pool()).value();
    publisher_ = std::make_unique<Publisher>(*writer_);
  }
  /// Makes a bridge. `options` are those of the kernel's bridge.
  bool make_bridge(const std::string& options) {
    const bool made = run("ip link set lo up && ip link add bridge type bridge " + options);
    if (made) links_.emplace_back("bridge");
    return made;
  }
  bool plug_in(unsigned number, const std::string& end) {
    const std::string& port = links_.emplace_back("port" + std::to_string(number));
    return run("ip link add " + port + " type veth peer name " + end + " && ip link set " + port +
               " master bridge up");
  }
  static std::string address_of(unsigned number) { return "10.20.0." + std::to_string(number) + "/24"; }
  static bool switch_on(unsigned number, const std::string& end) {
    return run("ip address add " + address_of(number) + " dev " + end + " && ip link set " + end + " up");
  }
  /// Runs `make` on another host. All that `make` opens stays on that host. Returns false if no host can be
  /// made.
  bool on_host(unsigned number, const std::function<void()>& make) {
    const std::string end = "end" + std::to_string(number);
    return plug_in(number, end) && on_host_behind(end, address_of(number), make);
  }
  /// Adds a reader on a host of its own.
  bool add_reader(unsigned number, const std::string& mask, bool reliable) {
    return add_readers(number, {mask}, reliable);
  }
  /// Adds readers on one host. Each has a transport of its own, as in separate programs.
  bool add_readers(unsigned number, const std::vector<std::string>& masks, bool reliable) {
    return on_host(number, [&] {
      for (const std::string& mask : masks) hosts_.push_back(open_reader(mask, reliable));
    });
  }
  Host open_reader(const std::string& mask, bool reliable) {
    Host host;
    host.mask = mask;
    host.reliable = reliable;
    host.transport = open_udp_transport({}, make_pool()).value();
    host.address = host.transport->addresses().at(0);
    host.subscriber =
        std::make_unique<Subscriber>(*host.transport, std::vector{mask}, 10'000, hosts_.size() + 1);
    if (reliable) host.subscriber->listen_reliably_to(publisher_->id());
    if (!reliable) host.subscriber->listen_to(publisher_->id());
    return host;
  }

  void serve(std::size_t first) {
    for (std::size_t i = served_; i < first; ++i) hosts_[i].since = published_;
    served_ = first;
    std::vector<Publisher::Reader> readers;
    for (std::size_t i = 0; i < first; ++i)
      readers.push_back({hosts_[i].address, hosts_[i].mask, hosts_[i].reliable});
    publisher_->serve(readers);
  }
  /// Returns true if all served readers get all samples that they should have.
  bool all_came() {
    for (std::size_t i = 0; i < served_; ++i) {
      const std::size_t count = published_ - hosts_[i].since;
      if (hosts_[i].subscriber->await(count).size() != count) return false;
    }
    return true;
  }
  /// Waits until all readers have all samples, and publishes the next one.
  void publish() {
    ASSERT_TRUE(all_came());
    Image image = make_image(data_bytes, ++published_);
    image.name.assign(name_bytes, 'n');
    publisher_->publish(image);
    writer_->poll(std::chrono::steady_clock::now());
  }
  void publish(std::size_t count) {
    for (std::size_t i = 0; i < count && !HasFatalFailure(); ++i) publish();
  }
  bool hears(core::EndpointId reader) {
    const std::string state = publisher_->port().multicast(reader);
    return state.starts_with("group ") && !state.ends_with("more");
  }
  bool all_are_in_groups() {
    for (core::EndpointId reader = 1; reader <= served_; ++reader) {
      if (!hears(reader)) return false;
    }
    return true;
  }
  /// Publishes repeatedly until the condition holds. Returns false if the condition never holds.
  template <class Condition>
  bool publish_until(const Condition& holds) {
    return eventually([&] {
      publish();
      return HasFatalFailure() || holds();
    });
  }

  static constexpr std::size_t data_bytes = 5000, name_bytes = 3000;

  std::unique_ptr<core::Network> writer_;
  std::unique_ptr<Publisher> publisher_;
  std::vector<Host> hosts_;
  std::size_t served_ = 0;
  std::uint32_t published_ = 0;

 private:
  std::vector<std::string> links_;
};

}  // namespace sft::udp::test
