#include <algorithm>

#include "tools/demo/clouds/scene_source.h"
#include "tools/demo/roles/protocol.h"
#include "tools/demo/roles/roles.h"

namespace sft::demo {

namespace {

/// One thread answers orders, and publishes when it is time.
class LidarRole {
 public:
  static Result<std::unique_ptr<LidarRole>> open(const NodePlan& plan) {
    Result<std::unique_ptr<RoleNode>> node = RoleNode::open(plan);
    if (!node) return tl::unexpected(node.error());
    Result<Publisher<PointCloud2>> publisher = (*node)->node().publisher<PointCloud2>(topic);
    if (!publisher) return tl::unexpected(publisher.error());
    return std::unique_ptr<LidarRole>(new LidarRole(std::move(*node), std::move(*publisher)));
  }

  /// Serves until the channel closes. Returns an error of publishing unless the error may be temporary.
  Result<void> serve(Channel& channel) {
    for (;;) {
      const Channel::Received received = channel.receive(next_);
      if (received.event == Channel::Event::closed) return {};
      if (received.event == Channel::Event::message) {
        follow(received.message.get<Order>());
        channel.send(report());
      } else if (Result<void> published = publish(); !published) {
        return published;
      }
    }
  }

 private:
  LidarRole(std::unique_ptr<RoleNode> node, Publisher<PointCloud2> publisher)
      : node_(std::move(node)), publisher_(std::move(publisher)) {}

  void follow(const Order& order) {
    if (order.kind == Order::Kind::report) return;
    next_.reset();
    ordered_ = published_;
    if (order.kind == Order::Kind::halt) return;
    ordered_ += order.samples;
    period_ = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / order.hz));
    next_ = Clock::now();
  }

  Result<void> publish() {
    const double seconds = std::chrono::duration<double>(period_).count() * static_cast<double>(published_);
    const Result<PublishStatus> result = source_.publish(publisher_, seconds);
    if (!result && result.error().code != Errc::out_of_memory) return tl::unexpected(result.error());
    ++published_;
    if (!result || *result != PublishStatus::ok) ++dropped_;
    // A late publisher does not try to catch up, as a sensor would not.
    next_ = std::max(*next_ + period_, Clock::now());
    if (published_ == ordered_) next_.reset();
    return {};
  }

  PublisherReport report() {
    PublisherReport report;
    report.published = published_;
    report.dropped = dropped_;
    report.full_bytes = source_.full_bytes();
    report.finished = !next_.has_value();
    for (const PublisherStatus::Reader& reader : publisher_.status().readers) {
      report.readers.push_back(
          {reader.node, reader.served, to_string(reader.transport), reader.reason, reader.withheld});
    }
    const NodeStatus status = node_->node().status();
    report.udp = status.udp;
    report.shm = status.shm;
    report.shm_ready = status.shm_ready;
    report.warning = node_->last_warning();
    report.traffic = node_->traffic();
    return report;
  }

  std::unique_ptr<RoleNode> node_;
  Publisher<PointCloud2> publisher_;
  const SceneSource source_;
  std::uint64_t ordered_ = 0;  // publishing ends with this number of samples
  std::uint64_t published_ = 0;
  std::uint64_t dropped_ = 0;
  Clock::duration period_{};
  std::optional<Clock::time_point> next_;  // empty: nothing to publish
};

}  // namespace

void run_publisher(const NodePlan& plan, Channel& channel) {
  Result<std::unique_ptr<LidarRole>> role = LidarRole::open(plan);
  const Result<void> served = role ? (*role)->serve(channel) : tl::unexpected(role.error());
  if (!served) refuse(channel, served.error());
}

}  // namespace sft::demo
