#include "bench/common/contest.h"
#include "bench/typesupport/messages.h"
#include "bench/typesupport/typesupport.h"
#include "sft/detail/project.h"

namespace sft::bench {

namespace {

using namespace detail;

template <class T>
double projection_ns(const T& message, const char* fields, int rounds) {
  const TypeSupport type(TypeTable<T>::type);
  const ProjectionPlan plan(type.type(), type.closed(type.parse_mask(fields).value()));
  Sample sample(message);
  Projection projection;
  return best_times_ns({batch_of([&] { keep(projection.project(sample.state(), plan)); })}, rounds)[0];
}

}  // namespace

std::vector<Figure> gathering(int rounds) {
  return {{"gather_plan_17_fields",
           projection_ns(odometry(), "header child_frame_id pose.pose twist.twist", rounds),
           "ns",
           {},
           "Odometry without covariances",
           300},
          // In a shifted gather, the runs move by a distance that is not a multiple of their alignment, so
          // they are copied leaf by leaf.
          {"gather_17_shifted",
           projection_ns(battery(),
                         "header.stamp voltage temperature current charge capacity design_capacity "
                         "percentage power_supply_status power_supply_health power_supply_technology present "
                         "cell_voltage cell_temperature location serial_number",
                         rounds),
           "ns",
           {},
           "BatteryState without frame_id",
           {}},
          {"gather_cloud_without_height",
           projection_ns(cloud(large_bytes),
                         "header width fields is_bigendian point_step row_step data is_dense", rounds),
           "ns",
           {},
           "of 1.66 MB",
           {}},
          {"gather_names_of_fields",
           projection_ns(cloud(large_bytes), "fields[].name", rounds),
           "ns",
           {},
           "of 1.66 MB",
           {}}};
}

}  // namespace sft::bench
