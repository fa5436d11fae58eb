#include "tools/demo/clouds/input_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "sft/sample.h"
#include "sft/typesupport/sample_format.h"
#include "tools/terminal/units.h"

namespace sft::demo {

namespace {

constexpr Req<PointCloud2> everything = all<PointCloud2>;

/// A payload, walked and indexed, so that its fields can be read.
class PayloadReader {
 public:
  explicit PayloadReader(std::span<const std::byte> payload)
      : body_(payload.subspan(encapsulation_bytes)),
        mask_(cloud_type().full()),
        index_(cloud_type().slots()) {
    status_ = build_index(state(), cloud_type().type(), index_, &body_end_);
  }

  WalkStatus status() const { return status_; }
  std::size_t bytes() const { return encapsulation_bytes + body_end_; }
  SampleState state() const {
    return {.body = body_.data(),
            .body_bytes = static_cast<std::uint32_t>(body_.size()),
            .index = index_.data(),
            .mask = &mask_};
  }

 private:
  std::span<const std::byte> body_;
  FieldMask mask_;
  std::vector<std::uint32_t> index_;
  std::uint32_t body_end_ = 0;
  WalkStatus status_ = WalkStatus::ok;
};

/// Bytes of another type may well have the shape of a PointCloud2; then its figures contradict each other.
Result<void> check_figures(const PayloadReader& reader) {
  const SampleState state = reader.state();
  const auto cloud = view_of<PointCloud2, everything>(state);
  const std::uint64_t row_bytes = std::uint64_t{cloud.width()} * cloud.point_step();
  const std::uint64_t data_bytes = std::uint64_t{cloud.height()} * cloud.row_step();
  if (cloud.row_step() >= row_bytes && cloud.data().size() == data_bytes) return {};
  return fail(
      Errc::type_mismatch,
      fmt::format(
          "not a sensor_msgs/PointCloud2: {} x {} points of {} bytes, in rows of {}, do not fit with {} "
          "bytes of data",
          cloud.height(), cloud.width(), cloud.point_step(), cloud.row_step(), cloud.data().size()));
}

Result<void> check_size(std::size_t bytes) {
  if (bytes <= cloud_bytes_max) return {};
  return fail(Errc::limit_exceeded,
              fmt::format("a cloud of {}, but a sample may have {} at most; give a smaller one",
                          tool::aligned_bytes_text(static_cast<double>(bytes)),
                          tool::aligned_bytes_text(static_cast<double>(cloud_bytes_max))));
}

}  // namespace

Result<EncodedCloud> check_payload(std::span<const std::byte> payload) {
  if (payload.size() < encapsulation_bytes) return fail(Errc::malformed, "too short for an encoded message");
  if (std::memcmp(payload.data(), encapsulation_cdr_le.data(), 2) != 0) {
    return fail(Errc::malformed,
                fmt::format("it begins with {:02x} {:02x}, not with 00 01, as messages in "
                            "little-endian CDR do",
                            static_cast<unsigned>(payload[0]), static_cast<unsigned>(payload[1])));
  }
  if (Result<void> size = check_size(payload.size()); !size) return tl::unexpected(size.error());
  const PayloadReader reader(payload);
  if (reader.status() != WalkStatus::ok) {
    return fail(Errc::malformed,
                fmt::format("not a sensor_msgs/PointCloud2, or damaged ({}); give a file of point clouds",
                            to_string(reader.status())));
  }
  return check_figures(reader).map([&] {
    return EncodedCloud{{payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(reader.bytes())}};
  });
}

Result<ConvertedCloud> convert(std::uint32_t height, std::uint32_t width, std::uint32_t point_step,
                               std::vector<sensor_msgs::msg::PointField> fields,
                               std::span<const std::byte> data) {
  if (Result<void> size = check_size(data.size()); !size) return tl::unexpected(size.error());
  ConvertedCloud cloud;
  cloud.prototype.header.frame_id = "lidar";
  cloud.prototype.height = height;
  cloud.prototype.width = width;
  cloud.prototype.fields = std::move(fields);
  cloud.prototype.point_step = point_step;
  cloud.prototype.row_step = point_step * width;
  cloud.data.resize(data.size());
  std::memcpy(cloud.data.data(), data.data(), data.size());
  return cloud;
}

std::string shape_of(const InputCloud& cloud) {
  if (const auto* converted = std::get_if<ConvertedCloud>(&cloud)) {
    return format_shape(converted->prototype.height, converted->prototype.width);
  }
  const PayloadReader reader(std::get<EncodedCloud>(cloud).payload);
  const SampleState state = reader.state();
  const auto view = view_of<PointCloud2, everything>(state);
  return format_shape(view.height(), view.width());
}

}  // namespace sft::demo
