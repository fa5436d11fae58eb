// Measures the time that recording adds to a getter, and the time that it takes once for each sample.
#include <algorithm>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <utility>
#include <visualization_msgs/msg/InteractiveMarker.hpp>

#include "bench/common/contest.h"
#include "bench/negotiation/negotiation.h"
#include "core/seam/buffer_pool.h"
#include "core/subscribe/recorder.h"
#include "sft/detail/encode.h"
#include "sft/sample.h"

namespace sft::bench {

namespace {

using namespace detail;

using core::Recorder;
using sensor_msgs::msg::PointCloud2;
using visualization_msgs::msg::InteractiveMarker;

/// One encoded message, which a reader receives repeatedly.
template <class T>
class Samples {
 public:
  explicit Samples(const T& message) {
    const EncodedSize size = encoded_size(type().type(), &message, type().full());
    const SampleLayout layout(type().index_slots());
    buffer_ = pool_->take(layout.body_offset + size.bytes);
    buffer_->mask = type().full();
    buffer_->header().body_bytes = size.bytes;
    encode(type().type(), &message, type().full(), {buffer_->data + layout.body_offset, size.bytes},
           {buffer_->index(), type().index_slots()});
  }

  template <Req<T> R>
  Sample<T, R> take() {
    return Sample<T, R>(untyped::Sample(core::SampleHandle(buffer_).release(), type(), {},
                                        R.is_recorded ? recorder_->begin() : nullptr));
  }

 private:
  static const TypeSupport& type() { return type_support<T>(); }

  const std::shared_ptr<core::BufferPool> pool_ = core::BufferPool::make(1 << 20);
  const std::shared_ptr<Recorder> recorder_ = Recorder::make(type().leaves(), {}, [] {});
  core::SampleHandle buffer_;
};

/// Measures the getters of a declared field, and of a recorded field that was already read.
class Getters {
 public:
  explicit Getters(int rounds) : rounds_(rounds) {}

  template <class T, class Get>
  void add(const std::string& name, const T& message, Get get) {
    Samples<T> samples(message);
    const auto declared = samples.template take<all<T>>();
    const auto recording = samples.template take<recorded>();
    const auto times =
        best_times_ns({batch_of([&] { keep(get(*declared.operator->().operator->())); }), batch_of([&] {
                         const auto value = get(*recording.operator->().operator->());
                         if (value) keep(*value);
                       })},
                      rounds_);
    figures_.push_back({"getter_recorded_" + name, times[1], "ns", times[0], "declared"});
    worst_ns_ = std::max(worst_ns_, times[1] - times[0]);
  }

  std::vector<Figure> figures() const {
    std::vector<Figure> all = {{"getter_overhead_recorded", worst_ns_, "ns", {}, "", 1}};
    all.insert(all.end(), figures_.begin(), figures_.end());
    return all;
  }

 private:
  int rounds_;
  std::vector<Figure> figures_;
  double worst_ns_ = 0;
};

/// Measures a sample in which eight leaves are read once: the time to record and count the reads, and the
/// time for a sample without reads.
template <class T, class Read>
std::vector<Figure> once_in_a_sample(const std::string& name, const T& message, int rounds, Read read_eight) {
  Samples<T> samples(message);
  const auto times =
      best_times_ns({batch_of([&] { keep(samples.template take<all<T>>().malformed()); }),
                     batch_of([&] { keep(samples.template take<recorded>().malformed()); }), batch_of([&] {
                       const auto sample = samples.template take<recorded>();
                       read_eight(*sample.operator->().operator->());
                     })},
                    rounds);
  return {{"recorded_sample_" + name, times[1] - times[0], "ns", {}, "begun and folded, nothing read"},
          {"recorded_first_read_" + name, (times[2] - times[1]) / 8, "ns", {}, "of a leaf, and counting it"}};
}

PointCloud2 cloud() {
  PointCloud2 cloud;
  cloud.header.frame_id = "lidar";
  cloud.fields.resize(4);
  cloud.data.resize(16);
  return cloud;
}

}  // namespace

std::vector<Figure> getter_overhead(const Scale& scale) {
  const int rounds = scale.rounds * 100;
  Getters getters(rounds);
  getters.add("scalar", cloud(), [](const auto& view) { return view.width(); });
  getters.add("nested", cloud(), [](const auto& view) { return view.header().stamp().sec(); });
  getters.add("string", cloud(), [](const auto& view) { return view.header().frame_id(); });
  getters.add("sequence", cloud(), [](const auto& view) { return view.data(); });
  getters.add("structs", cloud(), [](const auto& view) { return view.fields(); });
  getters.add("of_78", InteractiveMarker{}, [](const auto& view) { return view.scale(); });
  getters.add("structs_of_78", InteractiveMarker{}, [](const auto& view) { return view.controls(); });
  std::vector<Figure> figures = getters.figures();
  const auto add = [&](const std::vector<Figure>& more) {
    figures.insert(figures.end(), more.begin(), more.end());
  };
  add(once_in_a_sample("of_15", cloud(), rounds, [](const auto& view) {
    keep(view.header().stamp().sec());
    keep(view.header().stamp().nanosec());
    keep(view.height());
    keep(view.width());
    keep(view.is_bigendian());
    keep(view.point_step());
    keep(view.row_step());
    keep(view.is_dense());
  }));
  add(once_in_a_sample("of_78", InteractiveMarker{}, rounds, [](const auto& view) {
    keep(view.header().stamp().sec());
    keep(view.header().stamp().nanosec());
    keep(view.pose().position().x());
    keep(view.pose().position().y());
    keep(view.pose().position().z());
    keep(view.pose().orientation().x());
    keep(view.pose().orientation().w());
    keep(view.scale());
  }));
  return figures;
}

}  // namespace sft::bench
