#include "sft/detail/decode.h"

#include <nav_msgs/msg/Odometry.h>
#include <sensor_msgs/msg/PointCloud2.h>

#include "bench/common/contest.h"
#include "bench/typesupport/cyclone.h"
#include "bench/typesupport/messages.h"
#include "bench/typesupport/typesupport.h"
#include "sft/detail/view.h"

namespace sft::bench {

namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

/// Compares the reading of two scalars with the deserialization of the whole message in other middleware.
std::vector<Figure> two_scalars(int rounds) {
  Sample sample(cloud(large_bytes));
  CycloneMessage cyclone(sensor_msgs_msg_PointCloud2_desc);
  const auto best = best_times_ns({batch_of([&] {
                                     const auto view =
                                         view_of<PointCloud2, F::height | F::width>(sample.state());
                                     keep(view.height());
                                     keep(view.width());
                                   }),
                                   batch_of([&] { cyclone.read(sample.body()); })},
                                  rounds);
  return {{"read_two_scalars", best[0], "ns", {}, "of 1.66 MB", 20},
          {"read_two_scalars_vs_cyclone", best[0], "ns", best[1], "Cyclone's deserializer", {}}};
}

/// Checks and decodes a message, as for an arriving sample.
template <class T>
Figure full(const std::string& name, const T& message, const dds_topic_descriptor_t& type, int rounds) {
  Sample sample(message);
  CycloneMessage cyclone(type);
  T owned;
  const auto best = best_times_ns({batch_of([&] {
                                     keep(build_index(sample.state(), TypeTable<T>::type, sample.index()));
                                     keep(decode(sample.state(), TypeTable<T>::type, &owned));
                                   }),
                                   batch_of([&] { cyclone.read(sample.body()); })},
                                  rounds);
  return {"decode_" + name + "_vs_cyclone", best[0], "ns", best[1], "Cyclone's deserializer", {}};
}

}  // namespace

std::vector<Figure> decoding(int rounds) {
  std::vector<Figure> figures = two_scalars(rounds);
  figures.push_back(full("full_1.66MB", cloud(large_bytes), sensor_msgs_msg_PointCloud2_desc, rounds));
  figures.push_back(full("odometry", odometry(), nav_msgs_msg_Odometry_desc, rounds));
  return figures;
}

}  // namespace sft::bench
