#include "bench/common/contest.h"
#include "bench/typesupport/messages.h"
#include "bench/typesupport/typesupport.h"
#include "sft/detail/project.h"

namespace sft::bench {

using namespace detail;

std::vector<Figure> gathering(int rounds) {
  const auto message = odometry();
  const TypeSupport type(TypeTable<nav_msgs::msg::Odometry>::type);
  const FieldMask fields = type.parse_mask("header child_frame_id pose.pose twist.twist").value();
  const ProjectionPlan plan(type.type(), type.closed(fields));
  Sample sample(message);
  Projection projection;
  const auto best =
      best_times_ns({batch_of([&] { keep(projection.project(sample.state(), plan)); })}, rounds);
  return {{"gather_plan_17_fields", best[0], "ns", {}, "Odometry without covariances", 300}};
}

}  // namespace sft::bench
