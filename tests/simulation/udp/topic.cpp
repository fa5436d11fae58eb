#include "tests/simulation/udp/topic.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/seam/gate.h"
#include "tests/support/cut_reference.h"

namespace sft::simulation {

namespace {

/// Returns the selection that the sample names if it is a wish. Returns null for a union of masks and for
/// other selections.
const Selection* named_by(const core::SampleBuffer& sample) {
  if (sample.merged) return nullptr;
  const auto named = std::ranges::find_if(wishes(), [&](const Selection& wish) {
    return wish.mask() == sample.mask && wish.parts_hash() == sample.parts &&
           core::gate_id(wish.gate_hash(), 0) == sample.gate;
  });
  return named == wishes().end() ? nullptr : &*named;
}

/// Returns conditions that depend on the number and look random. The conditions suit clouds whose stamps
/// increase by 7 from one cloud to the next.
std::string any_conditions(int number) {
  const std::string text = std::to_string(number);
  if (number % 3 == 0) return "changed(header.stamp.sec) " + std::to_string(7 * (number % 4)) + "." + text;
  if (number % 3 == 1) return "every 2nd or header.stamp.sec == " + text;
  return "every 3rd and header.stamp.sec != " + text;
}

}  // namespace

Cloud make_cloud(std::size_t data_bytes, std::uint32_t number) {
  using sensor_msgs::msg::PointField;
  Cloud cloud;
  cloud.header.stamp = {.sec = static_cast<std::int32_t>(number), .nanosec = 7};
  cloud.header.frame_id = "lidar";
  cloud.fields = {{.name = "x", .offset = 0, .datatype = PointField::FLOAT32, .count = 1},
                  {.name = "y", .offset = 5, .datatype = PointField::FLOAT32, .count = 1},
                  {.name = "ring", .offset = 10, .datatype = PointField::UINT16, .count = 1}};
  cloud.point_step = 14;
  cloud.height = 1 + number % 3;
  cloud.width = static_cast<std::uint32_t>(data_bytes / (std::size_t{cloud.height} * cloud.point_step));
  cloud.row_step = cloud.width * cloud.point_step + number % 4;
  cloud.data.resize(std::size_t{cloud.height} * cloud.row_step);
  udp::test::fill_with_distances(cloud.data, number);
  return cloud;
}

const std::vector<Selection>& wishes() {
  static const std::vector<Selection> all = [] {
    std::vector<Selection> made;
    for (const char* text :
         {"*", "data", "header.stamp, width", "data{x}",
          "data{y,ring}[rows 1:3, columns 5:5000:2], header.stamp", "data[::3], header.frame_id",
          "* @ every 2nd", "data[:100] @ every 2nd", "data[::3] @ changed(header.stamp.sec) 9",
          "data{ring}[10:], is_dense @ every 3rd or header.stamp.sec < 500"})
      made.push_back(cloud_type().closed(cloud_type().parse_selection(text).value()));
    const std::array<std::string, 4> fields{"data{x}", "data[:100:2]", "header", "*"};
    // The selections are made in pairs with the same conditions. In half of the pairs both have the same
    // mask.
    for (int i = 0; i < 140; ++i) {
      const std::string text =
          fields[static_cast<std::size_t>(i) % fields.size()] + " @ " + any_conditions(i / 2);
      made.push_back(cloud_type().closed(cloud_type().parse_selection(text).value()));
    }
    return made;
  }();
  return all;
}

std::uint64_t name_of_selection(const core::SampleBuffer& sample) {
  if (sample.merged) return sample.mask.hash();
  const Selection* named = named_by(sample);
  return named == nullptr ? 0 : named->hash();
}

std::vector<std::byte> body_under(const Cloud& cloud, const core::SampleBuffer& sample) {
  const Selection* const named = named_by(sample);
  if (named == nullptr || named->parts().empty()) return udp::test::encoded_body(cloud, sample.mask);
  return udp::test::encoded_body(test::cut_reference::cut(cloud, named->parts().front()), sample.mask);
}

}  // namespace sft::simulation
