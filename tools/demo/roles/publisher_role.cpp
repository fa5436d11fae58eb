#include <algorithm>
#include <cstddef>
#include <optional>
#include <thread>

#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/node.h"
#include "sft/time.h"
#include "tools/demo/clouds/scene.h"
#include "tools/demo/roles/roles.h"

namespace sft::demo {

namespace {

using sensor_msgs::msg::PointCloud2;
using sensor_msgs::msg::PointField;

PointCloud2 scene_without_points() {
  PointCloud2 cloud;
  cloud.header.frame_id = "os_lidar";
  cloud.height = Scene::rows;
  cloud.width = Scene::columns;
  cloud.fields = {
      {"x", offsetof(LidarPoint, x), PointField::FLOAT32, 1},
      {"y", offsetof(LidarPoint, y), PointField::FLOAT32, 1},
      {"z", offsetof(LidarPoint, z), PointField::FLOAT32, 1},
      {"intensity", offsetof(LidarPoint, intensity), PointField::FLOAT32, 1},
      {"t", offsetof(LidarPoint, t), PointField::UINT32, 1},
      {"reflectivity", offsetof(LidarPoint, reflectivity), PointField::UINT16, 1},
      {"ring", offsetof(LidarPoint, ring), PointField::UINT16, 1},
      {"ambient", offsetof(LidarPoint, ambient), PointField::UINT16, 1},
      {"range", offsetof(LidarPoint, range), PointField::UINT32, 1},
  };
  cloud.point_step = sizeof(LidarPoint);
  cloud.row_step = Scene::columns * sizeof(LidarPoint);
  cloud.is_dense = true;
  return cloud;
}

/// Computes a cloud where its readers will read it, in memory that the publisher lends.
Result<PublishStatus> publish_scene(Publisher<PointCloud2>& publisher, double seconds) {
  using F = PointCloud2::Field;
  static const PointCloud2 prototype = scene_without_points();
  Result<Loan<PointCloud2>> loan = publisher.loan_for_overwrite(prototype, {.data = Scene::bytes});
  if (!loan) return tl::unexpected(loan.error());
  const auto stamp = time_message<builtin_interfaces::msg::Time>(std::chrono::system_clock::now());
  loan->set(F::header.stamp.sec, stamp.sec);
  loan->set(F::header.stamp.nanosec, stamp.nanosec);
  Scene::render(seconds, (*loan)->data());
  return std::move(*loan).publish();
}

/// "header, data{x,y,z}". Fields that only say how a part lies in a message are not named.
std::string names_of(const TypeSupport& type, const Selection& asked) {
  FieldMask whole = asked.mask();
  std::string parts;
  for (const Selection::Part& part : asked.parts()) {
    const Result<Selection> alone = Selection::make(type.none(), {part}, {});
    if (!alone) continue;
    whole -= type.closed(*alone).mask();
    parts += ", " + type.format_selection(*alone);
  }
  std::string names;
  for (const std::string& name : type.field_names(whole)) names += ", " + name;
  names += parts;
  return names.empty() ? "none" : names.substr(2);
}

Route route_of(const TypeSupport& type, const PublisherStatus::Reader& reader) {
  Route route;
  route.name = reader.node;
  route.served = reader.served;
  route.in_shared_memory = reader.transport == TransportKind::shm;
  route.reason = reader.reason;
  route.fields = names_of(type, reader.selection);
  route.all_fields = reader.selection.parts().empty() && reader.selection.mask().is_full();
  route.max_rate_hz = reader.max_rate_hz;
  route.withheld = reader.withheld;
  return route;
}

class Lidar {
 public:
  Lidar(Publisher<PointCloud2>& publisher, const PublishingPlan& plan) : publisher_(publisher), plan_(plan) {}

  /// Out of memory may pass; other errors are returned.
  Result<void> publish() {
    const auto& payloads = plan_.clouds.payloads;
    const Result<PublishStatus> status =
        payloads.empty() ? publish_scene(publisher_, static_cast<double>(published_) / plan_.hz)
                         : publisher_.publish_cdr(payloads[published_ % payloads.size()]);
    if (!status && status.error().code != Errc::out_of_memory) return tl::unexpected(status.error());
    ++published_;
    return {};
  }

  bool is_done() const { return published_ == plan_.samples; }

  PublisherReport report(bool halted) const {
    constexpr double encapsulation_bytes = 4;
    PublisherReport report{.published = published_, .finished = halted || is_done()};
    double sent = 0;
    double bytes = 0;
    std::size_t used = 0;
    for (const PublisherStatus::Reader& reader : publisher_.status().readers) {
      if (used == report.routes.size()) break;
      report.routes[used++] = route_of(publisher_.type(), reader);
      if (reader.bytes_sent == 0) continue;
      sent += static_cast<double>(reader.sent);
      bytes += static_cast<double>(reader.bytes_sent + reader.bytes_saved);
    }
    if (sent > 0) report.whole_bytes = bytes / sent + encapsulation_bytes;
    return report;
  }

 private:
  Publisher<PointCloud2>& publisher_;
  const PublishingPlan& plan_;
  std::uint64_t published_ = 0;
};

}  // namespace

Result<Node> open_node(const NodePlan& plan) {
  return Node::open({
      .name = plan.name,
      .domain = plan.domain,
      .transport = plan.transport,
      // The host of a subscriber is to show what that subscriber costs, but the switch passes multicast on to
      // all hosts.
      .udp = {.multicast = UdpSettings::Multicast::off},
      // The user's own configuration names interfaces of this machine, which other hosts do not have.
      .cyclonedds_config = "",
  });
}

Result<void> run_publisher(const NodePlan& plan, const PublishingPlan& publishing, Board& board) {
  Result<Node> node = open_node(plan);
  if (!node) return tl::unexpected(node.error());
  Result<Publisher<PointCloud2>> publisher = node->publisher<PointCloud2>(topic);
  if (!publisher) return tl::unexpected(publisher.error());
  Lidar lidar(*publisher, publishing);
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / publishing.hz));
  Clock::time_point next_cloud;
  while (board.order != Order::end) {
    const auto now = Clock::now();
    const auto next_report = now + between_reports;
    board.publisher.write(lidar.report(board.order == Order::halt));
    auto publishes = [&] { return board.order == Order::publish && !lidar.is_done(); };
    // A late publisher does not try to catch up, as a sensor would not.
    while (publishes() && std::max(next_cloud, now) < next_report) {
      std::this_thread::sleep_until(next_cloud);
      if (const Result<void> published = lidar.publish(); !published) return published;
      next_cloud = std::max(next_cloud + period, Clock::now());
    }
    std::this_thread::sleep_until(next_report);
  }
  return {};
}

}  // namespace sft::demo
