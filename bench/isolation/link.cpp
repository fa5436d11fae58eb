#include "bench/isolation/link.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

namespace sft::bench::isolation {

namespace {

void check(const Result<void>& done) {
  if (done) return;
  std::fprintf(stderr, "the link of the remote reader cannot be changed: %s\n", done.error().message.c_str());
  std::exit(1);
}

}  // namespace

void Link::make_lossy() const {
  check(network_->host(host_).run({"nft", "-f", "-"},
                                  fmt::format("table netdev loss {{\n"
                                              "  chain arriving {{\n"
                                              "    type filter hook ingress device {} priority 0;\n"
                                              "    numgen random mod 100 < {} drop\n"
                                              "  }}\n"
                                              "}}\n",
                                              hosts::host_interface, lossy_percent)));
}

void Link::lose_nothing() const {
  check(network_->host(host_).run({"nft", "delete", "table", "netdev", "loss"}));
}

void Link::make_narrow() const {
  check(network_->run_on_switch({"tc", "qdisc", "add", "dev", hosts::EmulatedNetwork::port(host_), "root",
                                 "tbf", "rate", fmt::format("{}mbit", narrow_mbit_s), "burst", "16kb",
                                 "latency", "50ms"}));
}

void Link::widen() const {
  check(network_->run_on_switch({"tc", "qdisc", "del", "dev", hosts::EmulatedNetwork::port(host_), "root"}));
}

}  // namespace sft::bench::isolation
