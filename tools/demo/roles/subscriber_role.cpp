#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "core/sync/mutex.h"
#include "tools/demo/roles/consumers.h"
#include "tools/demo/roles/latency.h"
#include "tools/demo/roles/protocol.h"
#include "tools/demo/roles/roles.h"

namespace sft::demo {

namespace {

/// Counts sample by sample. Threads of the node call on_sample(); the thread of the role calls the rest.
class Record {
 public:
  explicit Record(RoleNode& node) : node_(node) {}

  template <class Sample>
  void on_sample(const Sample& sample, std::chrono::system_clock::time_point arrival, bool may_learn) {
    const core::Lock lock(mutex_);
    latency_.add(arrival - sample.info().source_stamp);
    ++received_;
    // In shared memory cdr() would copy what the subscriber reads in place.
    if (sample.info().transport == TransportKind::udp) payload_bytes_ += sample.cdr().size();
    if (may_learn && !learnt_) watch_learning(sample.mask().is_full());
  }

  void add_to(SubscriberReport& report) {
    const core::Lock lock(mutex_);
    report.payload_bytes = payload_bytes_;
    report.latency_p50_us = latency_.percentile_us(0.50);
    report.latency_p99_us = latency_.percentile_us(0.99);
    if (learnt_) report.learning = after_full_sample_;
  }

 private:
  /// Learning costs all bytes until the last full sample has come. Only the next sample, which is not full,
  /// shows that it was the last one. So the state after each full sample is kept.
  void watch_learning(bool full) SFT_REQUIRES(mutex_) {
    if (!full) {
      learnt_ = true;
    } else {
      after_full_sample_ = {received_, payload_bytes_, node_.traffic()};
    }
  }

  RoleNode& node_;
  core::Mutex mutex_;
  LatencyRecord latency_ SFT_GUARDED_BY(mutex_);
  std::uint64_t received_ SFT_GUARDED_BY(mutex_) = 0;
  std::uint64_t payload_bytes_ SFT_GUARDED_BY(mutex_) = 0;
  LearningReport after_full_sample_ SFT_GUARDED_BY(mutex_);
  bool learnt_ SFT_GUARDED_BY(mutex_) = false;
};

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

template <class Consumer, Req<PointCloud2> R>
class SubscriberRole {
 public:
  static Result<std::unique_ptr<SubscriberRole>> open(const NodePlan& plan) {
    Result<std::unique_ptr<RoleNode>> node = RoleNode::open(plan);
    if (!node) return tl::unexpected(node.error());
    std::unique_ptr<SubscriberRole> role(new SubscriberRole(std::move(*node)));
    auto subscriber = role->node_->node().template subscriber<PointCloud2, R>(
        topic, [self = role.get()](const Sample<PointCloud2, R>& sample) { self->on_sample(sample); },
        {.max_rate_hz = Consumer::max_rate_hz});
    if (!subscriber) return tl::unexpected(subscriber.error());
    role->subscriber_.emplace(std::move(*subscriber));
    return role;
  }

  void serve(Channel& channel) {
    while (channel.receive({}).event == Channel::Event::message) channel.send(report());
  }

 private:
  explicit SubscriberRole(std::unique_ptr<RoleNode> node) : node_(std::move(node)), record_(*node_) {}

  void on_sample(const Sample<PointCloud2, R>& sample) {
    const auto arrival = std::chrono::system_clock::now();
    Consumer::read(sample.view(), use_);
    record_.on_sample(sample, arrival, R.is_recorded);
  }

  SubscriberReport report() {
    SubscriberReport report;
    const SubscriberStatus status = subscriber_->status();
    for (const SubscriberStatus::Writer& writer : status.writers) {
      report.matched |= writer.matched;
      report.transport = to_string(writer.transport);
      report.reason = writer.reason;
    }
    report.received = status.received;
    report.lost = status.lost;
    report.incomplete = node_->node().status().samples_incomplete;
    report.fields = names_of(subscriber_->type(), status.selection);
    report.other_fields = subscriber_->type().field_names(~status.mask);
    record_.add_to(report);
    report.warning = node_->last_warning();
    report.traffic = node_->traffic();
    return report;
  }

  std::unique_ptr<RoleNode> node_;
  Record record_;
  Use use_;                                               // the callback uses it
  std::optional<Subscriber<PointCloud2, R>> subscriber_;  // last, since its callback uses the others
};

template <class Consumer, Req<PointCloud2> R>
void run(const NodePlan& plan, Channel& channel) {
  auto role = SubscriberRole<Consumer, R>::open(plan);
  role ? (*role)->serve(channel) : refuse(channel, role.error());
}

}  // namespace

template <class Consumer>
void run_subscriber(const NodePlan& plan, bool is_recorded, Channel& channel) {
  constexpr Req<PointCloud2> declared = Consumer::fields;
  constexpr Req<PointCloud2> learnt = recorded;
  is_recorded ? run<Consumer, learnt>(plan, channel) : run<Consumer, declared>(plan, channel);
}

template void run_subscriber<Health>(const NodePlan&, bool, Channel&);
template void run_subscriber<Dashboard>(const NodePlan&, bool, Channel&);
template void run_subscriber<Recorder>(const NodePlan&, bool, Channel&);
template void run_subscriber<Localiser>(const NodePlan&, bool, Channel&);
template void run_subscriber<Detector>(const NodePlan&, bool, Channel&);

}  // namespace sft::demo
