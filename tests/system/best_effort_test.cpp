// Best effort between two hosts, over a cable that loses, repeats and swaps frames. The reported losses are
// exactly the samples that the subscriber missed.
#include <gtest/gtest.h>

#include <sft/sft.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <random>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/support/pace.h"
#include "tests/support/test_seed.h"
#include "tests/system/lossy_cable.h"
#include "tests/system/node_process.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using namespace std::chrono_literals;

constexpr std::uint32_t samples_sent = 1000;
constexpr double bytes_max = 100'000;  // about 70 datagrams: most samples of this size lose a datagram

struct Published {
  std::atomic<bool> failed{false};
  std::atomic<bool> served{false};
  std::atomic<std::uint32_t> wanted{0};  ///< the number of samples to publish
  std::atomic<std::uint32_t> count{0};
  std::atomic<std::uint64_t> dropped{0};  ///< the number of samples that the publisher itself has dropped
};

struct Taken {
  std::atomic<bool> failed{false};
  std::atomic<bool> wrong{false};  ///< true: a sample had wrong bytes, or was out of order
  std::atomic<std::uint32_t> last{0};
  std::atomic<std::uint64_t> count{0}, reported{0}, lost{0}, late{0};
};

std::uint8_t byte_of(std::uint32_t number, std::size_t at) {
  return static_cast<std::uint8_t>(number + at * 31 + at / 256);
}

void publish_clouds(Node& node, Published& published) {
  auto publisher = node.publisher<PointCloud2>("points").value();
  std::mt19937_64 random{test_seed()};
  std::uniform_real_distribution<> exponent(0, std::log(bytes_max));
  Pace pace(1ms);
  for (;; pace.await_turn()) {
    const PublisherStatus status = publisher.status();
    published.served = status.readers.size() == 1 && status.readers[0].served;
    if (published.served) published.dropped = status.readers[0].dropped;
    if (published.count >= published.wanted) continue;
    const std::uint32_t number = published.count + 1;
    PointCloud2 cloud{.height = number};
    cloud.data.resize(static_cast<std::size_t>(std::exp(exponent(random))));
    for (std::size_t i = 0; i < cloud.data.size(); ++i) cloud.data[i] = byte_of(number, i);
    publisher.publish(cloud);
    published.count = number;
  }
}

void check_clouds(Node& node, Taken& taken) {
  auto subscriber =
      node.subscriber<PointCloud2, F::height | F::data>("points", {.depth = samples_sent + 10}).value();
  for (;;) {
    subscriber.wait(5ms);
    while (const auto sample = subscriber.take()) {
      const std::uint32_t number = sample->height();
      bool right = number > taken.last && sample.info().sequence == number;
      for (std::size_t i = 0; i < sample->data().size(); ++i)
        right = right && sample->data()[i] == byte_of(number, i);
      if (!right) taken.wrong = true;
      taken.reported += sample.info().lost_before;
      ++taken.count;
      taken.last = number;
    }
    const SubscriberStatus status = subscriber.status();
    taken.lost = status.lost;
    taken.late = status.discarded;
  }
}

class BestEffortTest : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
    auto made = LossyCable::create({}, test_seed());
    if (!made) GTEST_SKIP() << made.error().message;
    cable_ = std::move(*made);
    ASSERT_TRUE(eventually([&] { return cable_->notes().ready.load(); }));
  }
  static NodeOptions options() {
    NodeOptions options{.transport = TransportChoice::udp};
    options.udp.use_io_uring = GetParam();
    return options;
  }
  /// Returns the number of samples, up to the one with the number `last`, of which the cable has lost a part.
  std::uint64_t harmed(std::uint32_t last) const {
    const auto& harmed = cable_->notes().harmed;
    return static_cast<std::uint64_t>(std::count(harmed.begin(), harmed.begin() + last + 1, true));
  }

  std::unique_ptr<LossyCable> cable_;
};

INSTANTIATE_TEST_SUITE_P(By, BestEffortTest, testing::Bool(),
                         [](const auto& param) { return param.param ? "IoUring" : "Sockets"; });

/// The cable has no faults while the first and the last sample are sent, so that all samples between them
/// are accounted for.
TEST_P(BestEffortTest, TellsASubscriberExactlyWhatWasDroppedOnTheWay) {
  SCOPED_TRACE(how_to_repeat());
  const NodeProcessWith<Published> publisher(cable_->host(0), options(), publish_clouds);
  const NodeProcessWith<Taken> subscriber(cable_->host(1), options(), check_clouds);
  Published& published = publisher.report();
  const Taken& taken = subscriber.report();
  const auto publish_up_to = [&](std::uint32_t number) {
    published.wanted = number;
    return eventually([&] { return published.count == number; });
  };
  ASSERT_TRUE(eventually([&] { return published.served.load(); }));
  ASSERT_TRUE(publish_up_to(1));
  ASSERT_TRUE(eventually([&] { return taken.last == 1; }));
  cable_->become(true);
  ASSERT_TRUE(publish_up_to(samples_sent));
  cable_->become(false);
  ASSERT_TRUE(publish_up_to(samples_sent + 1));
  ASSERT_TRUE(eventually([&] { return taken.last == samples_sent + 1 && taken.lost == taken.reported; }));

  EXPECT_FALSE(taken.wrong);
  EXPECT_EQ(taken.count + taken.reported, samples_sent + 1);
  EXPECT_GT(harmed(samples_sent + 1), samples_sent / 10) << "most are small, and a twentieth of these is";
  EXPECT_GT(cable_->notes().repeated, 0U);
  EXPECT_GT(cable_->notes().swapped, 0U);
  EXPECT_EQ(cable_->notes().failed, 0U);
  const auto accounted = [&] { return harmed(samples_sent + 1) + taken.late + published.dropped; };
  EXPECT_TRUE(eventually([&] { return taken.lost == accounted(); }))
      << taken.lost << " are lost; the cable harmed " << harmed(samples_sent + 1) << ", " << taken.late
      << " came behind later ones, and the publisher dropped " << published.dropped;
}

}  // namespace
}  // namespace sft::test
