#include "tests/conformance/fake_transport.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <iterator>
#include <mutex>
#include <utility>
#include <vector>

#include "core/platform/clock.h"
#include "core/subscribe/remote_copy.h"
#include "tests/conformance/fake_inbox.h"

namespace sft::test {

using namespace detail;
using core::EndpointId;
using core::HistoryProgress;
using core::Reach;
using core::SampleHandle;
using core::SendStatus;
using core::Source;

class FakeNetwork {
 public:
  void add(EndpointId reader, std::shared_ptr<FakeInbox> inbox) {
    const std::scoped_lock lock(mutex_);
    inboxes_.emplace_back(reader, std::move(inbox));
  }
  void remove(const FakeInbox& inbox) {
    const std::scoped_lock lock(mutex_);
    std::erase_if(inboxes_, [&](const auto& entry) { return entry.second.get() == &inbox; });
  }
  std::shared_ptr<FakeInbox> find(EndpointId reader) const {
    const std::scoped_lock lock(mutex_);
    for (const auto& [id, inbox] : inboxes_) {
      if (id == reader) return inbox;
    }
    return nullptr;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::pair<EndpointId, std::shared_ptr<FakeInbox>>> inboxes_;
};

std::shared_ptr<FakeNetwork> make_fake_network() { return std::make_shared<FakeNetwork>(); }

namespace {

/// The state that a transport shares with its ports.
struct FakeNode {
  FakeNode(std::shared_ptr<FakeNetwork> shared, const FakeOptions& given)
      : network(std::move(shared)), options(given), pool(core::BufferPool::make(given.pool_bytes)) {}
  const std::shared_ptr<FakeNetwork> network;
  const FakeOptions options;
  const std::shared_ptr<core::BufferPool> pool;
  std::atomic<bool> closed{false};
  std::atomic<std::uint64_t> over_limit{0};
};

/// The path to one reader. The list for the newest routes and the list for the present sample may share a
/// Line.
struct Line {
  core::Route route;
  std::shared_ptr<const ProjectionPlan> plan;
  std::shared_ptr<core::DeliveryTally> tally = std::make_shared<core::DeliveryTally>();
  bool awaits_history = route.history != 0;
  std::uint64_t oldest_retained = 0;
  std::vector<SampleHandle> waiting{};
};
using Lines = std::vector<std::shared_ptr<Line>>;

class FakeWriter final : public core::NetworkWriter {
 public:
  FakeWriter(const core::WriterSpec& spec, std::shared_ptr<FakeNode> node)
      : type_(*spec.type),
        node_(std::move(node)),
        book_(spec.book),
        copier_(core::RemoteCopy::make(type_, node_->pool)) {}

  // Called by the publisher's thread.

  SendStatus send(const SampleHandle& sample) noexcept override {
    begin_sample();
    return send_begun(sample, Reach::usual_routes);
  }
  // The writer of a fake transport never waits.
  void set_timeout(std::chrono::nanoseconds) noexcept override {}
  bool takes_postponed() const noexcept override { return false; }

  // Called by the agent's thread.

  void set_routes(std::vector<core::Route> routes) override {
    core::DeliveryBook::Page page;
    const std::scoped_lock lock(mutex_);
    Lines lines;
    for (core::Route& route : routes) {
      lines.push_back(line_for(std::move(route)));
      page.push_back(entry_of(*lines.back()));
    }
    if (book_ != nullptr) book_->enter(page);
    newest_ = std::move(lines);
  }

  void send_history(const core::Route& to, std::vector<SampleHandle> samples) override {
    Arrivals arrivals;
    const std::scoped_lock lock(mutex_);
    for (const auto& line : newest_) {
      if (line->route.reader != to.reader || !std::exchange(line->awaits_history, false)) continue;
      std::move(line->waiting.begin(), line->waiting.end(), std::back_inserter(samples));
      line->waiting.clear();
      if (!samples.empty()) line->oldest_retained = samples.front()->sequence;
      for (const SampleHandle& sample : samples) deliver(*line, *sample, arrivals);
    }
  }
  bool history_sent(EndpointId) noexcept override { return true; }

  // Called by any thread.

  Counters counters() const noexcept override { return {.bytes_sent = bytes_sent_}; }
  std::string multicast(EndpointId) const override { return {}; }
  std::string path_trouble(EndpointId) const override { return {}; }

 private:
  /// The inboxes at which samples have arrived. The destructor calls their listeners. Make the object
  /// before the lock is taken, so that the lock is released before the calls.
  struct Arrivals {
    std::vector<std::shared_ptr<FakeInbox>> inboxes{};
    ~Arrivals() {
      for (const auto& inbox : inboxes) inbox->announce();
    }
  };

  void begin_sample() noexcept override {
    const std::scoped_lock lock(mutex_);
    if (begun_ == newest_) return;
    begun_ = newest_;
    core::DeliveryBook::Page page;
    for (const auto& line : begun_) page.push_back(entry_of(*line));
    if (book_ != nullptr) book_->turn_to(core::DeliveryBook::Origin::network, page);
  }

  SendStatus send_begun(const SampleHandle& sample, Reach reach) noexcept override {
    if (node_->closed) return SendStatus::lost_port;
    if (sample->header().body_bytes > node_->options.max_sample_bytes) {
      ++node_->over_limit;
      miss_begun();
      return SendStatus::dropped;
    }
    Arrivals arrivals;
    const std::scoped_lock lock(mutex_);
    bool sent = true;
    for (const auto& line : begun_) {
      if (!is_for(*line, reach)) continue;
      if (line->awaits_history) {
        line->waiting.push_back(sample);
      } else {
        sent &= deliver(*line, *sample, arrivals);
      }
    }
    return sent ? SendStatus::sent : SendStatus::dropped;
  }

  void miss_begun() noexcept override {
    const std::scoped_lock lock(mutex_);
    for (const auto& line : begun_) {
      if (is_for(*line, Reach::usual_routes)) line->tally->dropped();
    }
  }

  // The samples of a batch are sent at once, because holding them back would save nothing in this transport.
  void hold(core::BatchTimeout) noexcept override {}
  std::size_t flush() noexcept override { return 0; }

  static bool is_for(const Line& line, Reach reach) {
    if (line.route.fallback && reach == Reach::usual_routes) return false;
    return line.route.gate == nullptr || line.route.gate->passes();
  }

  /// Returns the entry of a line in the delivery book. The entry of a fallback route has no gate, because the
  /// samples that the gate withholds are counted by the route that usually serves the reader.
  static std::pair<EndpointId, core::DeliveryMeter> entry_of(const Line& line) {
    const bool fallback = line.route.fallback;
    return {line.route.reader,
            {.tally = line.tally, .gate = fallback ? nullptr : line.route.gate, .diverted = fallback}};
  }

  /// Returns the line for a route. If the reader still awaits its history, this is the reader's existing
  /// line, so that its state is kept.
  std::shared_ptr<Line> line_for(core::Route route) const {
    auto plan = std::make_shared<const ProjectionPlan>(type_, route.selection);
    const auto goes_on = [&](const auto& known) {
      return known->route.reader == route.reader && known->route.history != 0 && route.history != 0;
    };
    const auto known = std::ranges::find_if(newest_, goes_on);
    if (known == newest_.end()) return std::make_shared<Line>(std::move(route), std::move(plan));
    (*known)->route = std::move(route);
    (*known)->plan = std::move(plan);
    return *known;
  }

  /// Delivers a copy of the sample. Returns false if there is no memory for the copy. A reader that no longer
  /// exists counts as served.
  bool deliver(const Line& line, const core::SampleBuffer& sample, Arrivals& arrivals) noexcept {
    std::shared_ptr<FakeInbox> inbox = node_->network->find(line.route.reader);
    if (inbox == nullptr) return true;
    SampleHandle copy = copy_of(sample);
    if (copy) copy = copier_->of(std::move(copy), *line.plan);
    if (!copy) {
      line.tally->dropped();
      return false;
    }
    if (line.route.history != 0) {
      copy->addressee = line.route.reader;
      copy->oldest_retained = line.oldest_retained;
    }
    if (line.route.gate != nullptr) {
      copy->min_period_us = line.route.min_period_us;
      copy->gate = line.route.gate->id();
      copy->ordinal = line.route.gate->ordinal();
    }
    const std::uint64_t body_bytes = copy->header().body_bytes;
    bytes_sent_ += body_bytes;
    line.tally->sent(body_bytes, std::max<std::uint64_t>(sample.whole_bytes, body_bytes));
    if (inbox->put(std::move(copy))) arrivals.inboxes.push_back(std::move(inbox));
    return true;
  }

  /// Copies the sample into memory for the reader, because the writer may reuse its own memory.
  SampleHandle copy_of(const core::SampleBuffer& sample) noexcept {
    const std::size_t bytes = sample.header().body_offset + sample.header().body_bytes;
    SampleHandle copy = node_->pool->take(bytes);
    if (!copy) return {};
    std::memcpy(copy->data, sample.data, bytes);
    copy->trust_header();
    copy->mask = sample.mask;
    copy->parts = sample.parts;
    copy->receive_stamp_ns = core::realtime_ns();
    return copy;
  }

  const TypeSupport& type_;
  const std::shared_ptr<FakeNode> node_;
  const std::shared_ptr<core::DeliveryBook> book_;  ///< null if deliveries are not counted
  std::atomic<std::uint64_t> bytes_sent_{0};

  // Guards the following members. The mutex is not held while listeners are called, because listeners may
  // send.
  std::mutex mutex_;
  const std::shared_ptr<core::RemoteCopy> copier_;
  Lines newest_;
  Lines begun_;  ///< the lines of the present sample
};

class FakeReader final : public core::NetworkReader {
 public:
  FakeReader(const core::ReaderSpec& spec, std::shared_ptr<FakeNode> node)
      : node_(std::move(node)), inbox_(std::make_shared<FakeInbox>(spec)) {
    node_->network->add(spec.id, inbox_);
  }
  ~FakeReader() override {
    node_->network->remove(*inbox_);
    inbox_->detach();
  }

  SampleHandle take() noexcept override { return inbox_->take(); }
  Result<void> connect(const Source& source) override {
    inbox_->connect(source);
    return {};
  }
  bool connected(EndpointId writer) const noexcept override { return inbox_->connected(writer); }
  void disconnect(EndpointId writer) noexcept override { inbox_->disconnect(writer); }
  HistoryProgress history(EndpointId writer) const noexcept override { return inbox_->history(writer); }
  std::uint64_t arrivals(EndpointId writer) noexcept override { return inbox_->arrivals(writer); }
  Counters counters() const noexcept override { return {inbox_->discarded(), inbox_->lost_unnoticed()}; }
  void accept(std::vector<core::Accepted> accepted) override { inbox_->accept(std::move(accepted)); }
  void announced(const Source&) override {}

  // Does nothing, because the sending thread delivers.
  bool receive(const core::Waiting&) noexcept override { return false; }
  void share_reader() override {}

 private:
  const std::shared_ptr<FakeNode> node_;
  const std::shared_ptr<FakeInbox> inbox_;
};

class FakeTransport final : public core::Network {
 public:
  FakeTransport(std::shared_ptr<FakeNetwork> network, const FakeOptions& options)
      : node_(std::make_shared<FakeNode>(std::move(network), options)) {}
  ~FakeTransport() override { node_->closed = true; }

  core::Availability poll(std::chrono::steady_clock::time_point) override {
    return core::Availability::ready;
  }
  std::size_t max_sample_bytes() const noexcept override { return node_->options.max_sample_bytes; }
  std::string description() const override { return "within this process"; }
  Counters counters() const noexcept override { return {.over_limit = node_->over_limit}; }

  Result<std::unique_ptr<core::NetworkWriter>> open_writer(const core::WriterSpec& spec) override {
    return std::make_unique<FakeWriter>(spec, node_);
  }
  Result<std::unique_ptr<core::NetworkReader>> open_reader(const core::ReaderSpec& spec) override {
    return std::make_unique<FakeReader>(spec, node_);
  }

  // Returns a placeholder, because the readers of a node without an address are not served. FakeNetwork
  // ignores addresses. No interface appears or disappears.
  std::vector<core::UdpAddress> addresses() const override {
    return {{.ip = core::loopback_ipv4, .port = 1}};
  }
  std::vector<core::Link> links() const override { return {}; }
  bool network_changed() noexcept override { return false; }
  void wake_receiver() noexcept override {}
  std::chrono::steady_clock::time_point next_poll() const override {
    return std::chrono::steady_clock::time_point::max();
  }
  void add_to(NodeStatus&) const override {}

 private:
  const std::shared_ptr<FakeNode> node_;
};

}  // namespace

std::unique_ptr<core::Network> open_fake_transport(std::shared_ptr<FakeNetwork> network,
                                                   const FakeOptions& options) {
  return std::make_unique<FakeTransport>(std::move(network), options);
}

}  // namespace sft::test
