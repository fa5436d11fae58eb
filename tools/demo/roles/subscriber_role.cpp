#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>
#include <vector>

#include "core/sync/mutex.h"
#include "sft/node.h"
#include "tools/demo/roles/consumers.h"
#include "tools/demo/roles/roles.h"
#include "tools/demo/roles/traffic.h"

namespace sft::demo {

namespace {

/// Counts sample by sample. Threads of the node call add(); the thread of the role calls fill().
class Record {
 public:
  Record(bool is_recorded, std::unique_ptr<TrafficMeter> meter, const std::atomic<Order>& order)
      : is_recorded_(is_recorded), meter_(std::move(meter)), order_(order) {}

  template <class Sample>
  void add(const Sample& sample, std::chrono::nanoseconds latency) {
    const core::Lock lock(mutex_);
    latencies_ns_.push_back(latency.count());
    // In shared memory cdr() would copy what the subscriber reads in place.
    if (sample.info().transport == TransportKind::udp)
      payload_bytes_ += static_cast<std::int64_t>(sample.cdr().size());
    if (is_recorded_ && !learnt_) watch_learning(sample.mask().is_full());
  }

  void fill(SubscriberReport& report) {
    const std::int64_t data = meter_ == nullptr ? 0 : meter_->data_received();
    const core::Lock lock(mutex_);
    if (order_ == Order::none) before_ = data;
    report.bytes = bytes(data);
    report.learning_bytes = learnt_ ? bytes_while_learning_ : is_recorded_ ? report.bytes : 0;
    report.steady_samples = latencies_ns_.size() - (learnt_ ? samples_while_learning_ : 0);
    report.steady_bytes = std::max<std::int64_t>(0, report.bytes - (learnt_ ? bytes_while_learning_ : 0));
    report.latency_p50_us = percentile_us(latencies_ns_, 0.50);
    report.latency_p99_us = percentile_us(latencies_ns_, 0.99);
  }

 private:
  /// Learning costs all bytes until the first sample that is not full, with which the steady state begins:
  /// full samples of which a part was lost cost their bytes, too.
  void watch_learning(bool full) SFT_REQUIRES(mutex_) {
    if (full) return;
    learnt_ = true;
    samples_while_learning_ = latencies_ns_.size();
    bytes_while_learning_ = bytes(meter_ == nullptr ? 0 : meter_->data_received());
  }

  /// `data`: what the meter says now. On the loopback, which counts no headers, that may be less than before.
  std::int64_t bytes(std::int64_t data) const SFT_REQUIRES(mutex_) {
    return meter_ == nullptr ? payload_bytes_ : std::max<std::int64_t>(0, data - before_);
  }

  const bool is_recorded_;
  const std::unique_ptr<TrafficMeter> meter_;  // null: bytes are those of the payload
  const std::atomic<Order>& order_;
  core::Mutex mutex_;
  std::int64_t before_ SFT_GUARDED_BY(mutex_) = 0;                 // what came before the first cloud
  std::vector<std::int64_t> latencies_ns_ SFT_GUARDED_BY(mutex_);  // an hour at 10 Hz takes 288 kB
  std::int64_t payload_bytes_ SFT_GUARDED_BY(mutex_) = 0;
  bool learnt_ SFT_GUARDED_BY(mutex_) = false;
  std::size_t samples_while_learning_ SFT_GUARDED_BY(mutex_) = 0;
  std::int64_t bytes_while_learning_ SFT_GUARDED_BY(mutex_) = 0;
};

template <class Consumer, Req<PointCloud2> R>
Result<void> subscribe(const NodePlan& plan, Board& board, std::size_t number) {
  std::unique_ptr<TrafficMeter> meter;
  if (plan.interface) {
    Result<std::unique_ptr<TrafficMeter>> opened = TrafficMeter::open(*plan.interface);
    if (!opened) return tl::unexpected(opened.error());
    meter = std::move(*opened);
  }
  Record record(R.is_recorded, std::move(meter), board.order);
  Result<Node> node = open_node(plan);
  if (!node) return tl::unexpected(node.error());
  const auto on_sample = [&record](const Sample<PointCloud2, R>& sample) {
    const auto arrival = std::chrono::system_clock::now();
    Consumer::read(sample.view());
    record.add(sample, arrival - sample.info().source_stamp);
  };
  const auto subscriber =
      node->template subscriber<PointCloud2, R>(topic, on_sample, {.max_rate_hz = Consumer::max_rate_hz});
  if (!subscriber) return tl::unexpected(subscriber.error());
  while (board.order != Order::end) {
    const SubscriberStatus status = subscriber->status();
    SubscriberReport report{.open = true, .received = status.received, .lost = status.lost};
    record.fill(report);
    board.subscribers[number].write(report);
    std::this_thread::sleep_for(between_reports);
  }
  return {};
}

template <class Consumer>
Result<void> run(const NodePlan& plan, bool is_recorded, Board& board, std::size_t number) {
  constexpr Req<PointCloud2> declared = Consumer::fields;
  constexpr Req<PointCloud2> learnt = recorded;
  return is_recorded ? subscribe<Consumer, learnt>(plan, board, number)
                     : subscribe<Consumer, declared>(plan, board, number);
}

template <class Consumer>
constexpr SubscriberRole role{Consumer::name, Consumer::purpose, run<Consumer>};

}  // namespace

double percentile_us(std::vector<std::int64_t> latencies_ns, double q) {
  if (latencies_ns.empty()) return 0;
  const auto count = static_cast<double>(latencies_ns.size());
  const double rank = std::clamp(std::ceil(q * count), 1.0, count);
  const auto nth = latencies_ns.begin() + static_cast<std::ptrdiff_t>(rank) - 1;
  std::nth_element(latencies_ns.begin(), nth, latencies_ns.end());
  return static_cast<double>(*nth) / 1000.0;
}

constinit const std::array<SubscriberRole, 5> subscriber_roles{role<Health>, role<Dashboard>, role<Recorder>,
                                                               role<Localiser>, role<Detector>};

}  // namespace sft::demo
