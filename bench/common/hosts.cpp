#include "bench/common/hosts.h"

#include <arpa/inet.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

namespace sft::bench {

namespace {

demo::EmulatedNetwork two_hosts() {
  auto network = demo::EmulatedNetwork::create(2);
  if (network) return std::move(*network);
  std::fprintf(stderr, "two hosts cannot be made (it takes root): %s\n", network.error().message.c_str());
  std::exit(1);
}

}  // namespace

TwoHosts::TwoHosts() : network_(two_hosts()) {}

Sides TwoHosts::sides(std::function<void(Exchange&)> sender, std::function<void(Exchange&)> receiver) const {
  const auto enter = [this](std::size_t host) {
    if (!network_.host(host).enter()) std::abort();
  };
  return {.sender = std::move(sender),
          .receiver = std::move(receiver),
          .enter_sender = [enter] { enter(0); },
          .enter_receiver = [enter] { enter(1); }};
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
