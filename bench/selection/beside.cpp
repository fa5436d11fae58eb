#include <sft/sft.h>
#include <unistd.h>
#include <zstd.h>

#include <atomic>
#include <bench_msgs/msg/Points.hpp>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <sensor_msgs/msg/CompressedImage.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <span>
#include <string>
#include <vector>

#include "bench/common/contest.h"
#include "bench/common/hosts.h"
#include "bench/common/message_set.h"
#include "bench/common/node_options.h"
#include "bench/common/process.h"
#include "bench/common/shared.h"
#include "bench/common/statistics.h"
#include "bench/selection/selection.h"
#include "tests/support/recorded_data.h"

namespace sft::bench {

namespace {

using bench_msgs::msg::Points;
using sensor_msgs::msg::CompressedImage;
using sensor_msgs::msg::PointCloud2;

constexpr std::uint64_t uncounted_clouds = 10;
constexpr std::int64_t cloud_period_us = 50'000;
constexpr std::size_t xyz_bytes = 12;
constexpr int quick_level = 1;  ///< the level at which zstd takes the least time

/// Publishes a cloud.
using PublishCloud = std::function<void(const PointCloud2&)>;
/// A function that is called for each reader that has read its points of a cloud.
using NoteRead = std::function<void()>;

/// A way in which readers on another host receive their points: x, y and z of every point, of every second
/// point, and of every fourth point.
struct Approach {
  /// Opens publishers, and waits until all readers are served. Returns the function that publishes a cloud.
  PublishCloud (*publish)(Node& node, std::size_t readers);
  /// Opens subscribers. They exist as long as the returned object.
  std::shared_ptr<void> (*subscribe)(Node& node, std::size_t readers, const NoteRead& note);
};

/// Returns n if the reader needs every n-th point.
std::size_t step_of(std::size_t reader) { return std::size_t{1} << reader; }

template <class T>
std::shared_ptr<Publisher<T>> served_publisher(Node& node, const std::string& topic, std::size_t readers) {
  const auto publisher =
      std::make_shared<Publisher<T>>(node.publisher<T>(topic, {.reliability = reliable}).value());
  if (!publisher->wait_for_subscribers(readers, std::chrono::seconds(20))) std::exit(1);
  return publisher;
}

/// Reads x, y and z of points that are `stride` bytes apart.
void read_points(std::span<const std::uint8_t> data, std::size_t stride) {
  float sum = 0;
  for (std::size_t at = 0; at + xyz_bytes <= data.size(); at += stride) {
    float xyz[3];
    std::memcpy(xyz, data.data() + at, sizeof xyz);
    sum += xyz[0] + xyz[1] + xyz[2];
  }
  keep(sum);
}

PublishCloud publish_once(Node& node, std::size_t readers) {
  const auto clouds = served_publisher<PointCloud2>(node, "points", readers);
  return [clouds](const PointCloud2& cloud) { clouds->publish(cloud); };
}

std::shared_ptr<void> subscribe_to_selections(Node& node, std::size_t readers, const NoteRead& note) {
  const auto all = std::make_shared<std::vector<Subscriber<PointCloud2, selected>>>();
  for (std::size_t i = 0; i < readers; ++i) {
    const auto read = [note](const sft::Sample<PointCloud2, selected>& cloud) {
      if (const auto found = cloud->points<float, float, float>("x", "y", "z")) {
        float sum = 0;
        for (const auto [x, y, z] : *found) sum += x + y + z;
        keep(sum);
      }
      note();
    };
    const std::string text = "header.stamp, data{x,y,z}[::" + std::to_string(step_of(i)) + "]";
    all->push_back(
        node.subscriber<PointCloud2, selected>("points", read, {.reliability = reliable, .selection = text})
            .value());
  }
  return all;
}

std::string topic_of_reader(std::size_t reader) { return "points_" + std::to_string(reader); }

PublishCloud publish_for_each(Node& node, std::size_t readers) {
  std::vector<std::shared_ptr<Publisher<Points>>> topics;
  for (std::size_t i = 0; i < readers; ++i)
    topics.push_back(served_publisher<Points>(node, topic_of_reader(i), 1));
  return [topics](const PointCloud2& cloud) {
    for (std::size_t i = 0; i < topics.size(); ++i) {
      const std::size_t stride = step_of(i) * cloud.point_step;
      const auto count = static_cast<std::uint32_t>(cloud.data.size() / stride);
      auto message = topics[i]->loan_for_overwrite({.stamp = cloud.header.stamp}, {.xyz = 3 * count}).value();
      float* xyz = message->xyz().data();
      for (std::size_t point = 0; point < count; ++point, xyz += 3)
        std::memcpy(xyz, cloud.data.data() + point * stride, xyz_bytes);
      std::move(message).publish();
    }
  };
}

std::shared_ptr<void> subscribe_to_each(Node& node, std::size_t readers, const NoteRead& note) {
  const auto all = std::make_shared<std::vector<Subscriber<Points>>>();
  for (std::size_t i = 0; i < readers; ++i) {
    const auto read = [note](const sft::Sample<Points>& message) {
      const std::span<const float> xyz = message->xyz();
      read_points({reinterpret_cast<const std::uint8_t*>(xyz.data()), xyz.size_bytes()}, xyz_bytes);
      note();
    };
    all->push_back(node.subscriber<Points>(topic_of_reader(i), read, {.reliability = reliable}).value());
  }
  return all;
}

PublishCloud publish_compressed(Node& node, std::size_t) {
  const auto packed = served_publisher<CompressedImage>(node, "points/zstd", 1);
  const std::shared_ptr<ZSTD_CCtx> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
  return [packed, context](const PointCloud2& cloud) {
    const auto most = static_cast<std::uint32_t>(ZSTD_compressBound(cloud.data.size()));
    auto message =
        packed->loan_for_overwrite({.header = cloud.header, .format = "zstd"}, {.data = most}).value();
    const std::size_t bytes = ZSTD_compressCCtx(context.get(), message->data().data(), most,
                                                cloud.data.data(), cloud.data.size(), quick_level);
    message.shrink(CompressedImage::Field::data, static_cast<std::uint32_t>(bytes));
    std::move(message).publish();
  };
}

/// Subscribes to compressed clouds. The host of the readers decompresses each cloud once for all readers.
std::shared_ptr<void> subscribe_to_compressed(Node& node, std::size_t readers, const NoteRead& note) {
  const std::shared_ptr<ZSTD_DCtx> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  const auto cloud = std::make_shared<std::vector<std::uint8_t>>();
  constexpr std::size_t point_step = 48;
  const auto read = [readers, note, context, cloud](const sft::Sample<CompressedImage>& message) {
    const std::span<const std::uint8_t> packed = message->data();
    cloud->resize(ZSTD_getFrameContentSize(packed.data(), packed.size()));
    ZSTD_decompressDCtx(context.get(), cloud->data(), cloud->size(), packed.data(), packed.size());
    for (std::size_t i = 0; i < readers; ++i) {
      read_points(*cloud, step_of(i) * point_step);
      note();
    }
  };
  return std::make_shared<Subscriber<CompressedImage>>(
      node.subscriber<CompressedImage>("points/zstd", read, {.reliability = reliable}).value());
}

/// The costs of a cloud.
struct Costs {
  double bytes = 0;  ///< bytes that the interface of the readers' host received, with all headers
  double publisher_ms = 0, subscriber_ms = 0;  ///< processor time of all threads
};

double cpu_ms() { return 1000 * cpu_s(getpid()); }

Costs costs_of(const TwoHosts& hosts, const Approach& approach, const PointCloud2& cloud, std::size_t readers,
               std::uint64_t clouds) {
  const Shared<Costs> costs;
  const std::uint64_t last = readers * (uncounted_clouds + clouds);
  const auto publish = [&](Exchange& exchange) {
    Node node = Node::open(udp_node_options("lidar")).value();
    const PublishCloud publish_cloud = approach.publish(node, readers);
    double before = 0;
    for (std::uint64_t n = 0; n < uncounted_clouds + clouds; ++n) {
      sleep_us(cloud_period_us);
      if (n == uncounted_clouds) before = cpu_ms();
      publish_cloud(cloud);
    }
    while (exchange.received.load() < last) sleep_us(cloud_period_us);
    costs->publisher_ms = (cpu_ms() - before) / static_cast<double>(clouds);
  };
  const auto subscribe = [&](Exchange& exchange) {
    Node node = Node::open(udp_node_options("station")).value();
    std::atomic<double> ms_before = 0;
    std::atomic<std::int64_t> bytes_before = 0;
    const auto note = [&] {
      const std::uint64_t read = ++exchange.received;
      if (read == readers * uncounted_clouds) {
        bytes_before = link_bytes().received;
        ms_before = cpu_ms();
      } else if (read == last) {
        costs->subscriber_ms = (cpu_ms() - ms_before) / static_cast<double>(clouds);
        costs->bytes =
            static_cast<double>(link_bytes().received - bytes_before) / static_cast<double>(clouds);
      }
    };
    const auto subscribers = approach.subscribe(node, readers, note);
    while (exchange.received.load() < last) sleep_us(cloud_period_us);
  };
  (void)run_deliveries(hosts.sides(publish, subscribe), 0);
  return *costs;
}

/// Returns the median of each cost.
Costs median_of(const std::vector<Costs>& rounds) {
  const auto of = [&](double Costs::*member) {
    std::vector<double> values;
    for (const Costs& round : rounds) values.push_back(round.*member);
    return median(values);
  };
  return {of(&Costs::bytes), of(&Costs::publisher_ms), of(&Costs::subscriber_ms)};
}

void add(std::vector<Figure>& figures, const std::string& name, const std::string& other, const Costs& ours,
         const Costs& theirs) {
  figures.push_back({name + "_wire", ours.bytes, "B", theirs.bytes, other});
  figures.push_back({name + "_publisher", ours.publisher_ms, "ms", theirs.publisher_ms, other});
  figures.push_back({name + "_subscriber", ours.subscriber_ms, "ms", theirs.subscriber_ms, other});
}

}  // namespace

std::vector<Figure> beside_narrow_topics_and_compression(std::uint64_t clouds, int rounds) {
  const auto file = test::recorded_data() / "lidar3d/ouster/pointcloud2_0.cdr";
  if (!std::filesystem::exists(file)) return {};
  constexpr std::size_t encapsulation_bytes = 4;
  const auto payload = test::read_recording(file).value();
  const PointCloud2 cloud = decoded<PointCloud2>(std::span(payload).subspan(encapsulation_bytes)).value();
  constexpr Approach selections{publish_once, subscribe_to_selections};
  constexpr Approach topics{publish_for_each, subscribe_to_each};
  constexpr Approach compression{publish_compressed, subscribe_to_compressed};
  const TwoHosts hosts;
  std::vector<Figure> figures;
  for (const std::size_t readers : {1, 3}) {
    std::vector<Costs> selected_rounds, topic_rounds, compressed_rounds;
    for (int round = 0; round < rounds; ++round) {
      selected_rounds.push_back(costs_of(hosts, selections, cloud, readers, clouds));
      topic_rounds.push_back(costs_of(hosts, topics, cloud, readers, clouds));
      compressed_rounds.push_back(costs_of(hosts, compression, cloud, readers, clouds));
    }
    const std::string suffix = "_" + std::to_string(readers);
    const Costs ours = median_of(selected_rounds);
    add(figures, "own_types" + suffix, "a topic of its own type for each reader", ours,
        median_of(topic_rounds));
    add(figures, "zstd" + suffix, "zstd of the whole cloud", ours, median_of(compressed_rounds));
  }
  return figures;
}

}  // namespace sft::bench
