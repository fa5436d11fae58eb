#include "tools/demo/roles.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <tuple>
#include <vector>

#include "core/sync/mutex.h"
#include "sft/points.h"
#include "tools/demo/reports.h"
#include "tools/demo/scene.h"
#include "tools/demo/traffic.h"
#include "tools/hosts/own_host.h"

namespace sft::demo {

namespace {

using F = PointCloud2::Field;

constexpr std::string_view topic = "points";

/// Returns the path of the sftd in the directory of this program; empty if SFT_DAEMON is set, or if there
/// is no such file. The library could not find that sftd: a process with its own mounts in a chroot cannot
/// reach the directory of its program any more.
std::string daemon_beside_program() {
  const std::filesystem::path daemon = hosts::program_directory() / "sftd";
  std::error_code error;
  const bool is_chosen = std::getenv("SFT_DAEMON") != nullptr;
  return is_chosen || !std::filesystem::exists(daemon, error) ? "" : daemon.string();
}

/// The parts of every role: a node, and the traffic of its host.
class RoleNode {
 public:
  Result<void> open(const RolePlan& plan) {
    if (plan.interface) {
      Result<std::unique_ptr<TrafficMeter>> meter = TrafficMeter::open(*plan.interface);
      if (!meter) return tl::unexpected(meter.error());
      meter_ = std::move(*meter);
    }
    // Multicast is off: the switch would forward it to all hosts, but the traffic of a host must show only
    // what its subscriber costs. The node does not use the user's configuration of Cyclone DDS, which names
    // interfaces that the hosts do not have.
    Result<Node> node = Node::open({.name = plan.name,
                                    .domain = plan.domain,
                                    .transport = plan.transport,
                                    .udp = {.multicast = UdpSettings::Multicast::off},
                                    .shm = {.daemon_path = daemon_beside_program()},
                                    .cyclonedds_config = "",
                                    .log = [](LogLevel, std::string_view) {}});
    if (!node) return tl::unexpected(node.error());
    node_.emplace(std::move(*node));
    return {};
  }

  Node& node() { return *node_; }
  /// Returns the bytes of data that the host has received; 0 if they are not measured.
  std::int64_t wire_bytes() { return meter_ == nullptr ? 0 : meter_->data_bytes(); }

 private:
  std::unique_ptr<TrafficMeter> meter_;
  std::optional<Node> node_;
};

/// The publisher. One thread answers orders, and publishes a cloud whenever one is due.
class Lidar {
 public:
  Result<void> open(const RolePlan& plan) {
    ordered_ = plan.options.samples;
    period_ = std::chrono::duration<double>(1.0 / plan.options.hz);
    return node_.open(plan)
        .and_then([this] { return node_.node().publisher<PointCloud2>(topic); })
        .map([this](Publisher<PointCloud2>&& publisher) { publisher_.emplace(std::move(publisher)); });
  }

  /// Serves until the channel closes. Returns an error if publishing fails, unless the failure may be
  /// temporary.
  Result<void> serve(Channel& channel) {
    for (;;) {
      if (next_ && !channel.readable_before(*next_)) {
        if (Result<void> published = publish(); !published) return published;
        continue;
      }
      const std::optional<nlohmann::json> order = channel.receive();
      if (!order) return {};
      if (*order == "begin") next_ = Clock::now();
      if (*order == "end") next_.reset();
      channel.send(report());
    }
  }

 private:
  Result<void> publish() {
    const double seconds = period_.count() * static_cast<double>(published_);
    const Result<PublishStatus> result = scene_.publish(*publisher_, seconds);
    if (!result && result.error().code != Errc::out_of_memory) return tl::unexpected(result.error());
    ++published_;
    // A late publisher does not publish faster to catch up, because a sensor would not do that.
    next_ = std::max(*next_ + std::chrono::duration_cast<Clock::duration>(period_), Clock::now());
    if (published_ == ordered_) next_.reset();
    return {};
  }

  PublisherReport report() {
    const NodeStatus status = node_.node().status();
    PublisherReport report{.published = published_,
                           .full_bytes = scene_.full_bytes(),
                           .finished = !next_.has_value(),
                           .readers = {},
                           .udp = status.udp,
                           .shm = status.shm,
                           .shm_ready = status.shm_ready};
    for (const PublisherStatus::Reader& reader : publisher_->status().readers)
      report.readers.push_back({reader.node, reader.served, to_string(reader.transport), reader.withheld});
    return report;
  }

  RoleNode node_;
  std::optional<Publisher<PointCloud2>> publisher_;
  const Scene scene_;
  std::uint64_t ordered_ = 0;  // publishing ends with this number of samples
  std::uint64_t published_ = 0;
  std::chrono::duration<double> period_{};
  std::optional<Clock::time_point> next_;  // when the next cloud is due; empty: nothing is to be published
};

// The subscribers: the fields that each of them declares, and the code that reads these fields. With --arr,
// no fields are declared, and the fields that the same code reads are recorded. read() returns a value that
// depends on all points, so that the compiler cannot remove the reads.

void read_header(const auto& cloud) {
  (void)cloud.header().stamp().sec();
  (void)cloud.header().stamp().nanosec();
  (void)cloud.header().frame_id();
}

/// Returns the sum over all points; 0 if the sample lacks a requested channel, which is possible while
/// fields are recorded.
float sum_of(const auto& points) {
  float sum = 0;
  if (!points) return sum;
  for (const auto& point : *points)
    std::apply([&sum](auto... values) { sum += (static_cast<float>(values) + ...); }, point);
  return sum;
}

struct Health {
  static constexpr Req<PointCloud2> fields = F::header | F::width;
  static float read(const auto& cloud) {
    read_header(cloud);
    (void)cloud.width();
    return 0;
  }
};

struct Dashboard {
  static constexpr Req<PointCloud2> fields = F::height | F::width | F::is_dense;
  static float read(const auto& cloud) {
    (void)cloud.height();
    (void)cloud.width();
    (void)cloud.is_dense();
    return 0;
  }
};

struct Recorder {
  static constexpr Req<PointCloud2> fields = F::header.stamp;
  static float read(const auto& cloud) {
    (void)cloud.header().stamp().sec();
    (void)cloud.header().stamp().nanosec();
    return 0;
  }
};

struct Localiser {
  static constexpr Req<PointCloud2> fields =
      F::header | F::data.channels<"x", "y", "z", "intensity">.every(2);
  static float read(const auto& cloud) {
    read_header(cloud);
    return sum_of(cloud.template points<float, float, float, float>("x", "y", "z", "intensity"));
  }
};

struct Detector {
  static constexpr Req<PointCloud2> fields = F::data.channels<"x", "y", "z">;
  static float read(const auto& cloud) {
    return sum_of(cloud.template points<float, float, float>("x", "y", "z"));
  }
};

/// Returns the smallest of `values` that is at least as large as a share `q` of them (nearest rank).
std::optional<double> percentile(std::vector<double> values, double q) {
  if (values.empty()) return std::nullopt;
  const auto nth = values.begin() + std::lround(std::ceil(q * static_cast<double>(values.size()))) - 1;
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

/// Returns the names of the requested fields and parts: "header", "data{x,y,z}". Fields that only describe
/// the layout of a part are left out.
std::vector<std::string> names_of(const TypeSupport& type, const Selection& asked) {
  FieldMask whole = asked.mask();
  std::vector<std::string> parts;
  for (const Selection::Part& part : asked.parts()) {
    const Result<Selection> alone = Selection::make(type.none(), {part}, {});
    if (!alone) continue;
    whole -= type.closed(*alone).mask();
    parts.push_back(type.format_selection(*alone));
  }
  std::vector<std::string> names = type.field_names(whole);
  names.insert(names.end(), parts.begin(), parts.end());
  return names;
}

/// Counts and reads samples. on_sample() is called by threads of the node, and all other functions by the
/// thread of the role.
template <class Consumer, Req<PointCloud2> R>
class Reader {
 public:
  Result<void> open(const RolePlan& plan) {
    return node_.open(plan)
        .and_then([&] {
          return node_.node().template subscriber<PointCloud2, R>(
              topic, [this](const Sample<PointCloud2, R>& sample) { on_sample(sample); },
              {.max_rate_hz = plan.max_rate_hz});
        })
        .map([this](Subscriber<PointCloud2, R>&& subscriber) { subscriber_.emplace(std::move(subscriber)); });
  }

  Result<void> serve(Channel& channel) {
    while (channel.receive()) channel.send(report());
    return {};
  }

 private:
  void on_sample(const Sample<PointCloud2, R>& sample) {
    const auto latency = std::chrono::system_clock::now() - sample.info().source_stamp;
    sum_ = Consumer::read(sample.view());
    const core::Lock lock(mutex_);
    latencies_us_.push_back(std::chrono::duration<double, std::micro>(latency).count());
    ++counts_.samples;
    // In shared memory, cdr() would copy data that the subscriber reads in place.
    if (sample.info().transport == TransportKind::udp) counts_.payload_bytes += sample.cdr().size();
    if (R.is_recorded && !has_learnt_) watch_learning(sample.mask().is_full());
  }

  /// Notes when the recorded mask has narrowed. All bytes until the last full sample count as the cost of
  /// recording. Only the next sample, which is not full, shows that it was the last full one. So the counts
  /// are stored after each full sample.
  void watch_learning(bool full) SFT_REQUIRES(mutex_) {
    has_learnt_ = !full;
    if (!full) return;
    counts_.wire_bytes = node_.wire_bytes();
    after_full_sample_ = counts_;
  }

  SubscriberReport report() {
    const SubscriberStatus status = subscriber_->status();
    SubscriberReport report;
    for (const SubscriberStatus::Writer& writer : status.writers) {
      report.matched |= writer.matched;
      report.transport = to_string(writer.transport);
      report.reason = writer.reason;
    }
    report.lost = status.lost;
    report.fields = names_of(subscriber_->type(), status.selection);
    report.asks_for_all = status.mask.is_full() && status.selection.parts().empty();
    {
      const core::Lock lock(mutex_);
      report.counts = counts_;
      report.p50_us = percentile(latencies_us_, 0.50);
      report.p99_us = percentile(latencies_us_, 0.99);
      if (has_learnt_) report.learnt = after_full_sample_;
    }
    report.counts.wire_bytes = node_.wire_bytes();
    return report;
  }

  RoleNode node_;
  core::Mutex mutex_;
  std::vector<double> latencies_us_ SFT_GUARDED_BY(mutex_);  // an hour at 10 Hz takes 288 kB
  Counts counts_ SFT_GUARDED_BY(mutex_);
  Counts after_full_sample_ SFT_GUARDED_BY(mutex_);
  bool has_learnt_ SFT_GUARDED_BY(mutex_) = false;
  volatile float sum_ = 0;
  // Must be the last member, since its callback uses the others
  std::optional<Subscriber<PointCloud2, R>> subscriber_;
};

template <class Role>
void run(const RolePlan& plan, Channel& channel) {
  Role role;
  const Result<void> served = role.open(plan).and_then([&] { return role.serve(channel); });
  if (!served) refuse(channel, served.error());
}

template <class Consumer>
void run_subscriber(const RolePlan& plan, Channel& channel) {
  plan.options.is_recorded ? run<Reader<Consumer, recorded>>(plan, channel)
                           : run<Reader<Consumer, Consumer::fields>>(plan, channel);
}

}  // namespace

void run_publisher(const RolePlan& plan, Channel& channel) { run<Lidar>(plan, channel); }

const std::array<SubscriberRole, 5> subscriber_roles{{
    {"health", "monitor", "watches that the lidar is alive and sees something", 0, run_subscriber<Health>},
    {"dashboard", "cockpit", "shows the operator how large the clouds are", 0, run_subscriber<Dashboard>},
    {"recorder", "logger", "writes down when each cloud was taken", 0, run_subscriber<Recorder>},
    // This role corrects its odometry from time to time, and needs every second column.
    {"localiser", "nav", "finds the robot on a map, by one cloud a second", 1, run_subscriber<Localiser>},
    // This role needs x, y and z of every point, and reads them in place.
    {"detector", "lidar", "finds objects, in the lidar's own memory", 0, run_subscriber<Detector>},
}};

}  // namespace sft::demo
