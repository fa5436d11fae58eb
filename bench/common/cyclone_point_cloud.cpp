#include "bench/common/cyclone_point_cloud.h"

namespace sft::bench {

CyclonePointCloud::CyclonePointCloud(std::size_t data_bytes) : cloud_(cloud(data_bytes)) {
  for (auto& field : cloud_.fields) {
    fields_.push_back({field.name.data(), field.offset, field.datatype, field.count});
  }
  const auto length = [](const auto& sequence) { return static_cast<std::uint32_t>(sequence.size()); };
  message_.header = {{cloud_.header.stamp.sec, cloud_.header.stamp.nanosec}, cloud_.header.frame_id.data()};
  message_.height = cloud_.height;
  message_.fields = {length(fields_), length(fields_), fields_.data(), false};
  message_.point_step = cloud_.point_step;
  message_.row_step = cloud_.row_step;
  message_.data = {length(cloud_.data), length(cloud_.data), cloud_.data.data(), false};
  message_.is_dense = cloud_.is_dense;
}

}  // namespace sft::bench
