// Reliable readers that take fewer samples than are published. Some publishers wait for these readers, others
// do not.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/transport_fixture.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using test::eventually;
using test::fields;
using test::Image;
using test::loopback_address;
using test::make_image;

constexpr std::uint32_t depth = 4;
constexpr std::uint64_t under_way_max = 4096;  // the number of samples that a channel keeps

/// A subscriber that takes samples only when the test calls it.
class SlowSubscriber final : private core::ArrivalListener {
 public:
  SlowSubscriber(core::Network& transport, const core::Source& source) {
    port_ = transport
                .open_reader({.id = 1,
                              .type = &test::type_support<Image>(),
                              .depth = depth,
                              .listener = this,
                              .doorbell = {}})
                .value();
    port_->accept({{.wanted = {fields<Image>("*")}}});
    EXPECT_TRUE(port_->connect(source));
  }
  /// Takes samples until the one with sequence `last`, and returns the sequences. Returns fewer after a
  /// time-out.
  std::vector<std::uint64_t> take_until(std::uint64_t last) {
    std::vector<std::uint64_t> sequences;
    eventually([&] {
      while (const core::SampleHandle sample = port_->take()) sequences.push_back(sample->header().sequence);
      return !sequences.empty() && sequences.back() >= last;
    });
    return sequences;
  }
  std::uint64_t discarded() const { return port_->counters().discarded; }

 private:
  void arrived() noexcept override {}
  std::unique_ptr<core::NetworkReader> port_;
};

class SlowReaderTest : public TransportTest {
 protected:
  static constexpr core::EndpointId writer = 7;

  /// Publishes that number of samples, and waits up to `max_blocking` for each.
  void publish(std::uint64_t samples, std::chrono::nanoseconds max_blocking) {
    const auto port = there_->open_writer({writer, &test::type_support<Image>(), true, max_blocking}).value();
    core::Route route{1, loopback_address(*here_), fields<Image>("*")};
    route.reliable = true;
    port->set_routes({route});
    const auto pool = test::make_pool();
    for (std::uint64_t sequence = 1; sequence <= samples; ++sequence) {
      const core::SampleHandle sample = pool->take(test::sample_bytes(make_image(20), fields<Image>("*")));
      test::fill(*sample, make_image(20), fields<Image>("*"), writer, sequence);
      port->send(sample);
      published_ = sequence;
    }
    // Waits before the port is closed, because closing a port discards the samples that the port keeps.
    eventually([&] { return over_.load(); });
  }

  std::unique_ptr<core::Network> here_ = nullptr, there_ = nullptr;
  std::atomic<std::uint64_t> published_{0};
  std::atomic<bool> over_{false};

  void SetUp() override {
    TransportTest::SetUp();
    if (IsSkipped()) return;
    here_ = open();
    there_ = open();
  }
};

INSTANTIATE_TEST_SUITE_P(Backends, SlowReaderTest, test::both_backends, test::backend_name);

TEST_P(SlowReaderTest, LosesNothingOfAPublisherThatWaitsForIt) {
  SlowSubscriber subscriber(*here_, {.writer = writer, .reliable = true, .waits = true});
  std::thread publisher([&] { publish(10'000, 60s); });
  EXPECT_TRUE(eventually([&] { return published_ == depth + under_way_max; })) << "then it waits";
  EXPECT_EQ(subscriber.take_until(10'000), first_numbers(10'000));
  EXPECT_EQ(subscriber.discarded(), 0U);
  over_ = true;
  publisher.join();
}

TEST_P(SlowReaderTest, LosesTheOldestOfAPublisherThatHasWaitedLongEnough) {
  constexpr std::uint64_t samples = depth + under_way_max + 300;
  SlowSubscriber subscriber(*here_, {.writer = writer, .reliable = true, .waits = true});
  std::thread publisher([&] { publish(samples, 1ms); });
  EXPECT_TRUE(eventually([&] { return published_ == samples; }));
  const std::vector<std::uint64_t> got = subscriber.take_until(samples);
  EXPECT_TRUE(std::ranges::is_sorted(got));
  EXPECT_EQ(got.empty() ? 0 : got.back(), samples);
  EXPECT_GT(subscriber.discarded(), 0U);
  EXPECT_GT(got.size(), samples / 2) << "no more than had to go";
  over_ = true;
  publisher.join();
}

}  // namespace
}  // namespace sft::udp
