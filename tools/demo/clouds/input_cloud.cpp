#include "tools/demo/clouds/input_cloud.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "sft/detail/encode.h"
#include "sft/detail/sample_format.h"
#include "sft/sample.h"
#include "tools/terminal/units.h"

namespace sft::demo {

namespace {

constexpr Req<PointCloud2> everything = all<PointCloud2>;

Result<void> check_size(std::size_t bytes) {
  if (bytes <= cloud_bytes_max) return {};
  return fail(Errc::limit_exceeded,
              fmt::format("a cloud of {}, but a sample may have {} at most; give a smaller one",
                          tool::aligned_bytes_text(static_cast<double>(bytes)),
                          tool::aligned_bytes_text(static_cast<double>(cloud_bytes_max))));
}

}  // namespace

Result<InputCloud> check_payload(std::span<const std::byte> payload) {
  if (payload.size() < detail::encapsulation_bytes)
    return fail(Errc::malformed, "too short for an encoded message");
  if (std::memcmp(payload.data(), detail::encapsulation_cdr_le.data(), 2) != 0) {
    return fail(Errc::malformed,
                fmt::format("it begins with {:02x} {:02x}, not with 00 01, as messages in "
                            "little-endian CDR do",
                            static_cast<unsigned>(payload[0]), static_cast<unsigned>(payload[1])));
  }
  if (Result<void> size = check_size(payload.size()); !size) return tl::unexpected(size.error());

  const std::span<const std::byte> body = payload.subspan(detail::encapsulation_bytes);
  const FieldMask mask = cloud_type().full();
  std::vector<std::uint32_t> index(cloud_type().index_slots());
  const detail::SampleState state{.body = body.data(),
                                  .body_bytes = static_cast<std::uint32_t>(body.size()),
                                  .index = index.data(),
                                  .mask = &mask};
  std::uint32_t body_end = 0;
  const detail::WalkStatus status = detail::build_index(state, cloud_type().type(), index, &body_end);
  if (status != detail::WalkStatus::ok) {
    return fail(Errc::malformed,
                fmt::format("not a sensor_msgs/PointCloud2, or damaged ({}); give a file of point clouds",
                            to_string(status)));
  }
  // Bytes of another type can be decoded as a PointCloud2. Then the sizes in them contradict each other.
  const auto cloud = detail::view_of<PointCloud2, everything>(state);
  const std::uint64_t row_bytes = std::uint64_t{cloud.width()} * cloud.point_step();
  const std::uint64_t data_bytes = std::uint64_t{cloud.height()} * cloud.row_step();
  if (cloud.row_step() < row_bytes || cloud.data().size() != data_bytes) {
    return fail(
        Errc::type_mismatch,
        fmt::format("not a sensor_msgs/PointCloud2: {} x {} points of {} bytes, in rows of {}, do not "
                    "fit with {} bytes of data",
                    cloud.height(), cloud.width(), cloud.point_step(), cloud.row_step(),
                    cloud.data().size()));
  }
  const auto end = static_cast<std::ptrdiff_t>(detail::encapsulation_bytes + body_end);
  return InputCloud{{payload.begin(), payload.begin() + end}, format_shape(cloud.height(), cloud.width())};
}

Result<std::vector<InputCloud>> convert(std::uint32_t height, std::uint32_t width, std::uint32_t point_step,
                                        std::vector<sensor_msgs::msg::PointField> fields,
                                        std::span<const std::byte> data) {
  if (Result<void> size = check_size(data.size()); !size) return tl::unexpected(size.error());
  PointCloud2 cloud;
  cloud.header.frame_id = "lidar";
  cloud.height = height;
  cloud.width = width;
  cloud.fields = std::move(fields);
  cloud.point_step = point_step;
  cloud.row_step = point_step * width;
  cloud.data.resize(data.size());
  std::transform(data.begin(), data.end(), cloud.data.begin(),
                 [](std::byte b) { return std::to_integer<std::uint8_t>(b); });

  const StructType& type = cloud_type().type();
  const FieldMask mask = cloud_type().full();
  const detail::EncodedSize size = detail::encoded_size(type, &cloud, mask);
  if (size.status != detail::EncodeStatus::ok) return fail(Errc::malformed, to_string(size.status));
  std::vector<std::uint64_t> body(size.bytes / 8 + 1);  // encode() takes aligned memory
  std::vector<std::uint32_t> index(cloud_type().index_slots());
  detail::encode(type, &cloud, mask, std::as_writable_bytes(std::span(body)).first(size.bytes), index);

  const std::span<const std::byte> encoded = std::as_bytes(std::span(body)).first(size.bytes);
  const std::span<const std::byte> encapsulation = std::as_bytes(std::span(detail::encapsulation_cdr_le));
  InputCloud input{{encapsulation.begin(), encapsulation.end()}, format_shape(height, width)};
  input.payload.insert(input.payload.end(), encoded.begin(), encoded.end());
  return std::vector<InputCloud>{std::move(input)};
}

}  // namespace sft::demo
