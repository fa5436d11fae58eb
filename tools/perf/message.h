// The message that a run sends again and again, and publishers of it.
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

/// Returns the JSON of a message with about so many bytes of data. Errc::invalid_argument if the type is
/// neither sensor_msgs/PointCloud2 nor std_msgs/UInt8MultiArray.
Result<std::string> json_of_size(std::string_view type, std::size_t bytes);

/// Publishes one message again and again: encoded bytes, or the same as a loan, of which only the small
/// fields are written each time.
class Sender {
 public:
  /// Loans are possible for sensor_msgs/PointCloud2, which this program was compiled with.
  static Result<Sender> open(Node& node, const std::string& topic, const DynamicType& type,
                             std::shared_ptr<const Payload> payload, bool loans,
                             const PublisherOptions& options);

  /// Returns true if the sample got a number, although a reader may miss it.
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
