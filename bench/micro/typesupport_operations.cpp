#include <memory>
#include <utility>

#include "bench/micro/operation.h"
#include "bench/typesupport/messages.h"
#include "sft/detail/project.h"
#include "sft/detail/view.h"
#include "sft/type_support.h"

namespace sft::bench::micro {

namespace {

using namespace detail;
using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

constexpr std::size_t medium_bytes = 16'000;
constexpr const char* all_but_covariances = "header child_frame_id pose.pose twist.twist";
constexpr const char* all_but_height = "header width fields is_bigendian point_step row_step data is_dense";

template <class T>
Operation encoding_of(const std::string& name, T value) {
  struct State {
    T message;
    Sample sample{message};
  };
  const auto state = std::make_shared<State>(std::move(value));
  return {"encode_" + name, state->sample.body().size(),
          batch_of([state] { state->sample.encode_again(&state->message); })};
}

template <class T>
Operation gathering_of(const std::string& name, const T& value, const char* fields) {
  struct State {
    State(const T& message, const char* text)
        : plan(type.type(), type.closed(type.parse_mask(text).value())), sample(message) {}

    const TypeSupport type{TypeTable<T>::type};
    const ProjectionPlan plan;
    Sample sample;
    Projection projection;
  };
  const auto state = std::make_shared<State>(value, fields);
  state->projection.project(state->sample.state(), state->plan);
  return {"gather_" + name, state->projection.bytes(),
          batch_of([state] { keep(state->projection.project(state->sample.state(), state->plan)); })};
}

}  // namespace

Operations encode_operations() {
  return {encoding_of("odometry", odometry()), encoding_of("cloud_16kB", cloud(medium_bytes)),
          encoding_of("cloud_1.66MB", cloud(large_bytes))};
}

Operations gather_operations() {
  return {gathering_of("odometry_17_fields", odometry(), all_but_covariances),
          gathering_of("cloud_16kB_without_height", cloud(medium_bytes), all_but_height)};
}

Operations view_operations() {
  const auto sample = std::make_shared<Sample>(cloud(medium_bytes));
  return {{"view_two_scalars", small_copy_bytes, batch_of([sample] {
             const auto view = view_of<PointCloud2, F::height | F::width>(sample->state());
             keep(view.height());
             keep(view.width());
           })},
          {"view_span", small_copy_bytes, batch_of([sample] {
             const auto view = view_of<PointCloud2, F::data | F::width>(sample->state());
             keep(view.data().size());
           })}};
}

Operations mask_operations() {
  struct State {
    const TypeSupport type{TypeTable<nav_msgs::msg::Odometry>::type};
    const FieldMask some = type.closed(type.parse_mask(all_but_covariances).value());
    const FieldMask others = type.closed(type.parse_mask("pose.covariance twist.covariance").value());
  };
  const auto state = std::make_shared<const State>();
  return {{"mask_parse", small_copy_bytes,
           batch_of([state] { keep(state->type.closed(*state->type.parse_mask(all_but_covariances))); })},
          {"mask_join", small_copy_bytes, batch_of([state] {
             const FieldMask both = state->some | state->others;
             keep(both.contains(state->some));
             keep(both.hash());
           })}};
}

}  // namespace sft::bench::micro
