#include "bench/common/hosts.h"

#include <arpa/inet.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

namespace sft::bench {

namespace {

[[noreturn]] void give_up(const Error& error) {
  std::fprintf(stderr, "the hosts cannot be made (it takes root): %s\n", error.message.c_str());
  std::exit(1);
}

}  // namespace

demo::EmulatedNetwork make_hosts(std::size_t hosts, Trains trains) {
  auto network = demo::EmulatedNetwork::create(hosts);
  if (!network) give_up(network.error());
  for (std::size_t i = 0; i < hosts && trains == Trains::whole; ++i) {
    const auto done =
        network->host(i).run({"ethtool", "-K", demo::host_interface, "tx-udp-segmentation", "on"});
    if (!done) give_up(done.error());
  }
  return std::move(*network);
}

TwoHosts::TwoHosts(Trains trains) : network_(make_hosts(2, trains)) {}

void TwoHosts::enter(std::size_t host) const {
  if (!network_.host(host).enter()) std::abort();
}

Sides TwoHosts::sides(std::function<void(Exchange&)> sender, std::function<void(Exchange&)> receiver) const {
  return {.sender = std::move(sender),
          .receiver = std::move(receiver),
          .enter_sender = [this] { enter(0); },
          .enter_receiver = [this] { enter(1); }};
}

std::uint32_t TwoHosts::receiver_address() { return inet_addr(demo::EmulatedNetwork::address(1).c_str()); }

LinkBytes link_bytes() {
  std::ifstream table("/proc/self/net/dev");  // of this process's namespace, unlike /sys
  for (std::string line; std::getline(table, line);) {
    const auto name = line.find(std::string(demo::host_interface) + ":");
    if (name == std::string::npos) continue;
    std::istringstream fields(line.substr(line.find(':') + 1));
    LinkBytes bytes;
    std::int64_t skipped = 0;
    fields >> bytes.received;
    for (int i = 0; i < 7; ++i) fields >> skipped;
    fields >> bytes.sent;
    return bytes;
  }
  return {};
}

}  // namespace sft::bench
