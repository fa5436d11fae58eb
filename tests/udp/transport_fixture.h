// Transports on loopback, over both backends and both families.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <numeric>
#include <ostream>
#include <vector>

#include "endpoints.h"
#include "udp_transport/udp_transport.h"

namespace sft::udp {

struct Way {
  Backend backend{};
  core::IpAddress loopback = core::loopback_ipv4;
  operator Backend() const {
    return backend;
  }  // NOLINT(google-explicit-constructor): most tests need no more
  friend std::ostream& operator<<(std::ostream& out, const Way& way) {
    return out << (way.backend == Backend::io_uring ? "io_uring" : "sockets")
               << (way.loopback.is_ipv4() ? "" : " over IPv6");
  }
};

class TransportTest : public testing::TestWithParam<Way> {
 protected:
  void SetUp() override {
    if (!GetParam().loopback.is_ipv4() && !test::has_ipv6_loopback()) GTEST_SKIP() << "there is no IPv6 here";
    const auto one = open_udp_transport({.backend = GetParam()}, test::make_pool());
    const auto other = open_udp_transport({.backend = GetParam()}, test::make_pool());
    if (!one || !other) GTEST_SKIP() << "io_uring is refused here: " << (one ? other : one).error().message;
  }

  std::unique_ptr<core::Transport> open(UdpOptions options = {}, const DecorateIo& decorate = {}) {
    options.backend = GetParam();
    options.bind_address = GetParam().loopback;
    return open_udp_transport(options, test::make_pool(), decorate).value();
  }

  static std::vector<std::uint64_t> first_numbers(std::size_t n) {
    std::vector<std::uint64_t> numbers(n);
    std::iota(numbers.begin(), numbers.end(), 1);
    return numbers;
  }
};

}  // namespace sft::udp
