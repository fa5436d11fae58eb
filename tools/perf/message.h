// The message that a run sends repeatedly, and its publishers.
#pragma once

#include <sft/sft.h>
#include <cstddef>
#include <memory>
#include <optional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace sft::perf {

/// An encoded message, with encapsulation.
using Payload = std::vector<std::byte>;

/// Returns the JSON of a message with about `bytes` bytes of data. Returns Errc::invalid_argument if the
/// type is neither sensor_msgs/PointCloud2 nor std_msgs/UInt8MultiArray.
Result<std::string> json_of_size(std::string_view type, std::size_t bytes);

/// Publishes one message repeatedly: as encoded bytes, or as a loan, in which only the small fields are
/// written each time.
class Sender {
 public:
  /// Opens the publisher. Loans are possible only for sensor_msgs/PointCloud2, because the program is
  /// compiled with this type.
  static Result<Sender> open(Node& node, const std::string& topic, const DynamicType& type,
                             std::shared_ptr<const Payload> payload, bool loans,
                             const PublisherOptions& options);

  /// Publishes the message. Returns true if the sample got a number. A reader may still miss it.
  bool send();
  PublisherStatus status() const { return encoded_ ? encoded_->status() : loans_->status(); }

 private:
  Sender() = default;
  void lend();

  std::shared_ptr<const Payload> payload_;
  std::optional<DynamicPublisher> encoded_;
  std::optional<Publisher<sensor_msgs::msg::PointCloud2>> loans_;
  std::optional<Loan<sensor_msgs::msg::PointCloud2>> next_;
  sensor_msgs::msg::PointCloud2 prototype_;
  std::uint32_t data_bytes_ = 0;
};

}  // namespace sft::perf
