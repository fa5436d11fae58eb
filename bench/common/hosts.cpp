#include "bench/common/hosts.h"

#include <arpa/inet.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "tools/hosts/interface_counters.h"

namespace sft::bench {

namespace {

[[noreturn]] void give_up(const Error& error) {
  std::fprintf(stderr, "cannot make the hosts (run this as root): %s\n", error.message.c_str());
  std::exit(1);
}

std::vector<std::string> options_of(Trains trains) {
  if (trains == Trains::whole) return {"tx-udp-segmentation", "on"};
  return {};
}

}  // namespace

hosts::EmulatedNetwork make_hosts(std::size_t hosts, Trains trains) {
  auto network = hosts::EmulatedNetwork::create(hosts);
  if (!network) give_up(network.error());
  const std::vector<std::string> options = options_of(trains);
  for (std::size_t i = 0; i < hosts && !options.empty(); ++i) {
    std::vector<std::string> command{"ethtool", "-K", hosts::host_interface};
    command.insert(command.end(), options.begin(), options.end());
    const auto done = network->host(i).run(command);
    if (!done) give_up(done.error());
  }
  return std::move(*network);
}

std::uint32_t address_of(std::size_t host) {
  return inet_addr(hosts::EmulatedNetwork::address(host).c_str());
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

LinkBytes link_bytes() {
  const auto bytes = hosts::interface_bytes(hosts::host_interface).value_or(hosts::InterfaceBytes{});
  return {static_cast<std::int64_t>(bytes.received), static_cast<std::int64_t>(bytes.sent)};
}

}  // namespace sft::bench
