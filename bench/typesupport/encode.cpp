#include "sft/detail/encode.h"

#include <nav_msgs/msg/Odometry.h>
#include <sensor_msgs/msg/PointCloud2.h>

#include <cstring>

#include "bench/common/contest.h"
#include "bench/typesupport/cyclone.h"
#include "bench/typesupport/messages.h"
#include "bench/typesupport/typesupport.h"

namespace sft::bench {

namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

/// Compares encoding with a copy. Both write to the same place in the sample's memory.
Figure full_cloud(int rounds) {
  const PointCloud2 message = cloud(large_bytes);
  Sample sample(message);
  const std::size_t slot = slot_offset(TypeTable<PointCloud2>::type, 7);
  std::byte* data = sample.body().data() + sample.index()[slot] + 4;
  const auto best = best_times_ns({batch_of([&] { sample.encode_again(&message); }),
                                   batch_of([&] { std::memcpy(data, message.data.data(), large_bytes); })},
                                  rounds);
  return {"encode_full_1.66MB", best[0] / 1000, "us", best[1] / 1000, "memcpy of its data", 1.15};
}

std::vector<Figure> height_and_width(int rounds) {
  const PointCloud2 large = cloud(large_bytes);
  const PointCloud2 small = cloud(small_bytes);
  const FieldMask mask(F::height | F::width);
  Sample sample(large, mask);
  const auto best = best_times_ns(
      {batch_of([&] { sample.encode_again(&large); }), batch_of([&] { sample.encode_again(&small); })},
      rounds);
  return {{"encode_height_width", best[0], "ns", {}, "of 1.66 MB", 100},
          {"encode_height_width_size", best[0], "ns", best[1], "the same, of 16 B of data", 1.5}};
}

template <class T>
Figure small_message(const std::string& name, T message, const dds_topic_descriptor_t& type, int rounds) {
  Sample sample(message);
  CycloneMessage cyclone(type);
  cyclone.read(sample.body());
  const auto best = best_times_ns(
      {batch_of([&] { sample.encode_again(&message); }), batch_of([&] { cyclone.write(); })}, rounds);
  return {"encode_" + name + "_vs_cyclone", best[0], "ns", best[1], "Cyclone's serializer", {}};
}

}  // namespace

std::vector<Figure> encoding(int rounds) {
  std::vector<Figure> figures{full_cloud(rounds)};
  for (const Figure& figure : height_and_width(rounds)) figures.push_back(figure);
  figures.push_back(small_message("odometry", odometry(), nav_msgs_msg_Odometry_desc, rounds));
  figures.push_back(small_message("cloud_16B", cloud(small_bytes), sensor_msgs_msg_PointCloud2_desc, rounds));
  return figures;
}

}  // namespace sft::bench
