// Transports on loopback, with both backends and both address families.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <numeric>
#include <ostream>
#include <string>
#include <vector>

#include "tests/transports/udp/backends.h"
#include "tests/transports/udp/endpoints.h"
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

inline const auto all_ways = testing::Values(Way{Backend::io_uring}, Way{Backend::sockets},
                                             Way{Backend::sockets, core::loopback_ipv6});

/// Returns the name of the way, as GoogleTest's name for the parameter.
inline constexpr auto way_name = [](const testing::TestParamInfo<Way>& info) {
  return test::backend_name(info) + (info.param.loopback.is_ipv4() ? "" : "IPv6");
};

class TransportTest : public testing::TestWithParam<Way> {
 protected:
  void SetUp() override {
    if (!GetParam().loopback.is_ipv4() && !test::has_ipv6_loopback()) GTEST_SKIP() << "there is no IPv6 here";
    if (const std::string why = test::refusal_of(GetParam()); !why.empty()) GTEST_SKIP() << why;
  }

  std::unique_ptr<core::Network> open(UdpOptions options = {}, const DecorateIo& decorate = {}) {
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
