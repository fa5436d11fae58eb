#include "tools/perf/message.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace sft::perf {

namespace {

using sensor_msgs::msg::PointCloud2;

constexpr std::uint32_t point_bytes = 16;
constexpr const char* channels[] = {"x", "y", "z", "intensity"};

bool sends(PublishStatus status) { return status == PublishStatus::ok || status == PublishStatus::dropped; }

/// Returns this number of zero bytes as base64.
std::string base64(std::size_t bytes) {
  std::string text((bytes + 2) / 3 * 4, 'A');
  for (std::size_t i = 0; i < (3 - bytes % 3) % 3; ++i) text[text.size() - 1 - i] = '=';
  return text;
}

PointCloud2 cloud_without_data(std::size_t bytes) {
  PointCloud2 cloud;
  cloud.header.frame_id = "lidar";
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(bytes / point_bytes);
  for (std::uint32_t i = 0; i < std::size(channels); ++i) cloud.fields.push_back({channels[i], 4 * i, 7, 1});
  cloud.point_step = point_bytes;
  cloud.row_step = point_bytes * cloud.width;
  cloud.is_dense = true;
  return cloud;
}

}  // namespace

Result<std::string> json_of_size(std::string_view type, std::size_t bytes) {
  if (type.ends_with("UInt8MultiArray")) return fmt::format(R"({{"data": "{}"}})", base64(bytes));
  if (!type.ends_with("PointCloud2"))
    return fail(
        Errc::invalid_argument,
        fmt::format("a message of {} cannot be made by its size, only one of sensor_msgs/PointCloud2 or "
                    "std_msgs/UInt8MultiArray: write it with --value, or take one from a topic by --like",
                    type));
  const PointCloud2 cloud = cloud_without_data(bytes);
  std::string fields;
  for (const auto& field : cloud.fields)
    fields += fmt::format(R"({}{{"name": "{}", "offset": {}, "datatype": 7, "count": 1}})",
                          fields.empty() ? "" : ", ", field.name, field.offset);
  return fmt::format(R"({{"header": {{"frame_id": "lidar"}}, "height": 1, "width": {}, "fields": [{}],
      "point_step": {}, "row_step": {}, "data": "{}", "is_dense": true}})",
                     cloud.width, fields, cloud.point_step, cloud.row_step, base64(cloud.row_step));
}

Result<Sender> Sender::open(Node& node, const std::string& topic, const DynamicType& type,
                            std::shared_ptr<const Payload> payload, bool loans,
                            const PublisherOptions& options) {
  Sender sender;
  sender.payload_ = std::move(payload);
  if (!loans)
    return node.publisher(topic, type, options).map([&](DynamicPublisher&& publisher) {
      sender.encoded_ = std::move(publisher);
      return std::move(sender);
    });
  if (type.hash() != type_support<PointCloud2>().hash())
    return fail(Errc::invalid_argument, "--loan needs messages of sensor_msgs/PointCloud2");
  constexpr std::size_t rest = 200;  // an upper bound for the size of everything but the data
  const std::size_t bytes = sender.payload_->size() - std::min(sender.payload_->size(), rest);
  sender.prototype_ = cloud_without_data(bytes);
  sender.data_bytes_ = sender.prototype_.row_step;
  return node.publisher<PointCloud2>(topic, options).map([&](Publisher<PointCloud2>&& publisher) {
    sender.loans_ = std::move(publisher);
    return std::move(sender);
  });
}

void Sender::lend() {
  next_.reset();
  if (auto loan = loans_->loan(prototype_, {.data = data_bytes_})) next_.emplace(*std::move(loan));
}

bool Sender::send() {
  if (encoded_) {
    const auto status = encoded_->publish_cdr(*payload_);
    return status && sends(*status);
  }
  if (!next_) lend();
  const bool sent = next_ && sends(std::move(*next_).publish());
  lend();  // done between samples, since setting the data to zero takes time
  return sent;
}

}  // namespace sft::perf
