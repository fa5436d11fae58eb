// A thousand samples of 1 B to 6.3 MB, log-uniformly distributed, from one publisher to one subscriber.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "tests/support/test_seed.h"
#include "tests/transports/udp/endpoints.h"

namespace sft::udp::test {

/// Sends the samples, several of them at the same time. Expects each to arrive in order and unchanged.
inline void transfer_all_sizes(Publisher& publisher, Subscriber& subscriber, sft::test::Random& random) {
  constexpr std::size_t samples = 1000, outstanding_max = 8;
  std::uniform_real_distribution<> exponent(0, std::log(6.3e6));
  std::vector<std::size_t> sizes;
  std::size_t checked = 0;
  const auto check_up_to = [&](std::size_t count) {
    for (const auto& sample : subscriber.await_new(count - checked)) {
      ASSERT_EQ(sample->sequence, ++checked);
      const auto seed = static_cast<std::uint32_t>(checked);
      ASSERT_TRUE(
          same_bytes(body_of(*sample), encoded_body(make_image(sizes[checked - 1], seed), sample->mask)));
    }
    ASSERT_GE(checked, count) << "the others did not come";
  };
  while (sizes.size() < samples) {
    sizes.push_back(static_cast<std::size_t>(std::exp(exponent(random))));
    publisher.publish(make_image(sizes.back(), static_cast<std::uint32_t>(sizes.size())));
    if (sizes.size() <= outstanding_max + checked) continue;
    ASSERT_NO_FATAL_FAILURE(check_up_to(sizes.size() - outstanding_max));
  }
  ASSERT_NO_FATAL_FAILURE(check_up_to(samples));
  EXPECT_EQ(checked, samples);
}

}  // namespace sft::udp::test
