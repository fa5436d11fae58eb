// Samples of sizes that are usual on robots, with default options.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <sensor_msgs/msg/Image.hpp>
#include <utility>
#include <vector>

#include "tests/support/isolated_host.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::Image;

/// A host as on robots: /dev/shm has 1900 MiB, which is less than half of 4 GB of RAM.
class LargeSamples : public PubSubTest {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
    shm_.emplace(1900);
  }
  template <class T>
  void expect_arrives(const T& message) {
    Node a = open("a");
    Node b = open("b");
    auto pub = a.publisher<T>("large").value();
    auto sub = b.subscriber<T>("large").value();
    expect_served(pub, 1);
    for (int i = 0; i < 3; ++i) {
      const auto arrives_within = [&](std::chrono::seconds time) {
        EXPECT_EQ(pub.publish(message), PublishStatus::ok);
        return sub.wait(time);
      };
      // By UDP, a best-effort reader may lose a large sample on a busy machine.
      ASSERT_TRUE(in_shared_memory() ? arrives_within(hang_timeout)
                                     : eventually([&] { return arrives_within(5s); }));
      const auto sample = sub.take();
      EXPECT_EQ(sample.info().transport, in_shared_memory() ? TransportKind::shm : TransportKind::udp);
      EXPECT_TRUE(sample.to_owned() == message) << i;
    }
    EXPECT_EQ(pub.status().diverted, PublisherStatus::Diverted{});
  }

 private:
  std::optional<ShmOfSize> shm_;
};

TEST_P(LargeSamples, AnImageOfA4KCameraArrives) {
  Image image;
  image.height = 2160;
  image.width = 3840;
  image.encoding = "rgb8";
  image.step = 3 * image.width;
  image.data.resize(std::size_t{image.step} * image.height);
  for (std::size_t i = 0; i < image.data.size(); i += 997) image.data[i] = static_cast<std::uint8_t>(i);
  expect_arrives(image);
}

TEST_P(LargeSamples, ACloudOf33MegabytesArrives) { expect_arrives(cloud(7, 33'000'000)); }

TEST_P(LargeSamples, ASampleOf64MiBArrives) { expect_arrives(cloud(7, 64 * 1024 * 1024 - 400)); }

INSTANTIATE_TEST_SUITE_P(Ways, LargeSamples, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

/// Three lidars with eight readers each, some of which stop taking samples.
class ThreeLidars : public ::testing::Test {
 protected:
  static constexpr std::size_t lidars = 3, readers = 8, cloud_bytes = 6'300'000;
  static constexpr std::uint32_t clouds = 24;

  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
    shm_.emplace(1900);
    node_.emplace(Node::open(node_options("robot")).value());
    other_.emplace(Node::open(node_options("others")).value());
    for (std::size_t i = 0; i < lidars; ++i) {
      const std::string topic = "lidar" + std::to_string(i);
      publishers_.push_back(node_->publisher<PointCloud2>(topic).value());
      for (std::size_t reader = 0; reader < readers; ++reader)
        subscribers_[i].push_back(other_->subscriber<PointCloud2>(topic).value());
    }
    for (const auto& publisher : publishers_) {
      ASSERT_TRUE(eventually([&] { return in_memory(publisher) == readers; })) << in_memory(publisher);
    }
  }
  static NodeOptions node_options(const std::string& name) {
    NodeOptions options{.name = name};
    options.shm.daemon_idle_exit = 5s;
    return options;
  }
  static std::size_t in_memory(const Publisher<PointCloud2>& publisher) {
    const PublisherStatus status = publisher.status();
    return static_cast<std::size_t>(std::ranges::count_if(status.readers, [](const auto& reader) {
      return reader.served && reader.transport == TransportKind::shm;
    }));
  }
  /// Publishes all clouds. Each reader takes the first cloud. The first `stalled` readers of each lidar take
  /// no later clouds, and the other readers take all of them.
  void publish_all(std::size_t stalled) {
    PointCloud2 cloud;
    cloud.data.resize(cloud_bytes);
    for (std::uint32_t number = 1; number <= clouds; ++number) {
      cloud.height = number;
      for (std::size_t i = 0; i < lidars; ++i) {
        ASSERT_EQ(publishers_[i].publish(cloud), PublishStatus::ok);
        for (std::size_t reader = number == 1 ? 0 : stalled; reader < readers; ++reader) {
          ASSERT_TRUE(subscribers_[i][reader].wait(hang_timeout));
          const auto sample = subscribers_[i][reader].take();
          ASSERT_EQ(sample->height(), number);
          ASSERT_EQ(sample.info().transport, TransportKind::shm);
        }
      }
    }
  }
  void expect_nothing_is_diverted() const {
    for (const auto& publisher : publishers_)
      EXPECT_EQ(publisher.status().diverted, PublisherStatus::Diverted{});
  }

  std::optional<ShmOfSize> shm_;
  std::optional<Node> node_, other_;
  std::vector<Publisher<PointCloud2>> publishers_;
  std::array<std::vector<Subscriber<PointCloud2>>, lidars> subscribers_;
};

TEST_F(ThreeLidars, DivertNothingIfOneReaderOfEachNeverTakes) {
  publish_all(1);
  expect_nothing_is_diverted();
}

TEST_F(ThreeLidars, DivertNothingIfNoReaderTakesAndTheNewestCloudsWait) {
  publish_all(readers);
  expect_nothing_is_diverted();
  for (auto& of_lidar : subscribers_) {
    for (Subscriber<PointCloud2>& subscriber : of_lidar) {
      std::uint32_t taken = 0, last = 0;
      while (const auto sample = subscriber.take()) {
        ++taken;
        last = sample->height();
      }
      EXPECT_EQ(last, clouds);
      EXPECT_EQ(taken, 5U) << "of 32 MiB";
      EXPECT_EQ(subscriber.status().lost, clouds - 1 - taken);
    }
  }
}

/// Tests that chunks occupy memory only once they are used.
class MemoryOnDemand : public ThreeLidars {
 protected:
  /// Returns the memory that all files in /dev/shm occupy, in MiB.
  static std::uint64_t used_mebibytes() {
    const std::filesystem::space_info space = std::filesystem::space("/dev/shm");
    return (space.capacity - space.free) >> 20;
  }
};

TEST_F(MemoryOnDemand, IsNotTakenBeforeLargeSamplesArePublished) {
  const std::uint64_t before = used_mebibytes();
  EXPECT_LE(before, 400U) << "of 1 GiB for samples, and what manages them";
  auto publisher = node_->publisher<PointCloud2>("large").value();
  auto subscriber = other_->subscriber<PointCloud2>("large").value();
  ASSERT_TRUE(eventually([&] { return in_memory(publisher) == 1; }));
  PointCloud2 cloud;
  cloud.data.resize(30'000'000);
  publisher.publish(cloud);
  ASSERT_TRUE(subscriber.wait(hang_timeout));
  const auto sample = subscriber.take();
  EXPECT_EQ(sample.info().transport, TransportKind::shm);
  EXPECT_GE(used_mebibytes(), before + 28);
}

TEST_F(MemoryOnDemand, ThatTheHostDoesNotHaveSendsSamplesByUdp) {
  const std::filesystem::path filler = "/dev/shm/filler";
  const int file = open(filler.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  const std::uint64_t left = std::filesystem::space("/dev/shm").free;
  ASSERT_EQ(posix_fallocate(file, 0, static_cast<off_t>(left - (8 << 20))), 0);
  auto publisher = node_->publisher<PointCloud2>("large", {.reliability = reliable}).value();
  auto subscriber = other_->subscriber<PointCloud2>("large", {.reliability = reliable}).value();
  ASSERT_TRUE(eventually([&] { return in_memory(publisher) == 1; }));
  PointCloud2 cloud;
  cloud.data.resize(30'000'000);
  const auto arrives_by = [&](TransportKind transport) {
    EXPECT_EQ(publisher.publish(cloud), PublishStatus::ok);
    EXPECT_TRUE(subscriber.wait(hang_timeout));
    const auto sample = subscriber.take();
    return sample && sample.info().transport == transport;
  };
  EXPECT_TRUE(arrives_by(TransportKind::udp)) << "and the program does not end";
  EXPECT_EQ(publisher.status().diverted.exhausted, 1U);
  close(file);
  std::filesystem::remove(filler);
  EXPECT_TRUE(arrives_by(TransportKind::shm));
}

}  // namespace
}  // namespace sft::test
