#include "tests/conformance/fake_transport.h"

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
using core::SampleHandle;
using core::SendStatus;

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

/// What a transport's ports share with it.
struct FakeNode {
  FakeNode(std::shared_ptr<FakeNetwork> shared, const FakeOptions& given)
      : network(std::move(shared)), options(given), pool(core::BufferPool::make(given.pool_bytes)) {}
  const std::shared_ptr<FakeNetwork> network;
  const FakeOptions options;
  const std::shared_ptr<core::BufferPool> pool;
  std::atomic<bool> closed{false};
  std::atomic<std::uint64_t> over_limit{0};
};

class FakeWriter final : public core::WriterPort {
 public:
  FakeWriter(const core::WriterSpec& spec, std::shared_ptr<FakeNode> node)
      : type_(*spec.type), node_(std::move(node)), copier_(type_, node_->pool) {}

  SendStatus send(const SampleHandle& sample) noexcept override {
    if (node_->closed) return SendStatus::lost_port;
    if (sample->header().body_bytes > node_->options.max_sample_bytes) {
      ++node_->over_limit;
      return SendStatus::dropped;
    }
    Arrivals arrivals;
    const std::scoped_lock lock(mutex_);
    bool sent = true;
    for (Line& line : lines_) {
      if (line.route.gate != nullptr && !line.route.gate->passes()) continue;
      if (line.awaits_history) {
        line.waiting.push_back(sample);
      } else {
        sent &= deliver(line, *sample, arrivals);
      }
    }
    return sent ? SendStatus::sent : SendStatus::dropped;
  }

  void set_routes(std::vector<core::Route> routes) override {
    const std::scoped_lock lock(mutex_);
    std::vector<Line> lines;
    for (core::Route& route : routes) lines.push_back(line_for(std::move(route)));
    lines_ = std::move(lines);
  }

  void send_history(const core::Route& to, std::vector<SampleHandle> samples) override {
    Arrivals arrivals;
    const std::scoped_lock lock(mutex_);
    for (Line& line : lines_) {
      if (line.route.reader != to.reader || !std::exchange(line.awaits_history, false)) continue;
      std::move(line.waiting.begin(), line.waiting.end(), std::back_inserter(samples));
      line.waiting.clear();
      if (!samples.empty()) line.oldest_retained = samples.front()->sequence;
      for (const SampleHandle& sample : samples) deliver(line, *sample, arrivals);
    }
  }

  std::uint64_t bytes_sent() const noexcept override { return bytes_sent_; }

 private:
  /// Listeners are called at its end, which comes after that of a lock taken later.
  struct Arrivals {
    std::vector<std::shared_ptr<FakeInbox>> inboxes{};
    ~Arrivals() {
      for (const auto& inbox : inboxes) inbox->announce();
    }
  };

  /// To one reader.
  struct Line {
    core::Route route;
    std::shared_ptr<const ProjectionPlan> plan;
    bool awaits_history = false;
    std::uint64_t oldest_retained = 0;
    std::vector<SampleHandle> waiting{};
  };

  /// A reader that is still late goes on where it was.
  Line line_for(core::Route route) {
    Line line{.route = std::move(route), .plan = nullptr, .awaits_history = false};
    line.plan = std::make_shared<const ProjectionPlan>(type_.type(), line.route.mask);
    line.awaits_history = line.route.history != 0;
    for (Line& known : lines_) {
      if (known.route.reader != line.route.reader || known.route.history == 0 || line.route.history == 0)
        continue;
      line.awaits_history = known.awaits_history;
      line.oldest_retained = known.oldest_retained;
      line.waiting = std::move(known.waiting);
    }
    return line;
  }

  /// False where there is no memory for it. A reader that left misses nothing.
  bool deliver(const Line& line, const core::SampleBuffer& sample, Arrivals& arrivals) noexcept {
    std::shared_ptr<FakeInbox> inbox = node_->network->find(line.route.reader);
    if (inbox == nullptr) return true;
    SampleHandle copy = copy_of(sample);
    if (copy) copy = copier_.of(std::move(copy), *line.plan);
    if (!copy) return false;
    if (line.route.history != 0) {
      copy->addressee = line.route.reader;
      copy->oldest_retained = line.oldest_retained;
    }
    if (line.route.gate != nullptr) {
      copy->min_period_us = line.route.min_period_us;
      copy->ordinal = line.route.gate->ordinal();
    }
    bytes_sent_ += copy->header().body_bytes;
    if (inbox->put(std::move(copy))) arrivals.inboxes.push_back(std::move(inbox));
    return true;
  }

  /// Memory of the reader's own: the writer's may be used again.
  SampleHandle copy_of(const core::SampleBuffer& sample) noexcept {
    const std::size_t bytes = sample.header().body_offset + sample.header().body_bytes;
    SampleHandle copy = node_->pool->take(bytes);
    if (!copy) return {};
    std::memcpy(copy->data, sample.data, bytes);
    copy->trust_header();
    copy->mask = sample.mask;
    copy->receive_stamp_ns = core::realtime_ns();
    return copy;
  }

  const TypeSupport& type_;
  const std::shared_ptr<FakeNode> node_;
  std::mutex mutex_;  // guards what follows; not held while listeners are called, which may send
  core::RemoteCopy copier_;
  std::vector<Line> lines_;
  std::atomic<std::uint64_t> bytes_sent_{0};
};

class FakeReader final : public core::ReaderPort {
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
  Result<void> connect(const core::Source& source) override {
    inbox_->connect(source);
    return {};
  }
  bool connected(EndpointId writer) const noexcept override { return inbox_->connected(writer); }
  HistoryProgress history(EndpointId writer) const noexcept override { return inbox_->history(writer); }
  std::uint64_t arrivals(EndpointId writer) noexcept override { return inbox_->arrivals(writer); }
  void disconnect(EndpointId writer) noexcept override { inbox_->disconnect(writer); }
  void accept(std::vector<core::Accepted> accepted) override { inbox_->accept(std::move(accepted)); }
  std::uint64_t discarded() const noexcept override { return inbox_->discarded(); }
  std::uint64_t lost_unnoticed() const noexcept override { return inbox_->lost_unnoticed(); }

 private:
  const std::shared_ptr<FakeNode> node_;
  const std::shared_ptr<FakeInbox> inbox_;
};

class FakeTransport final : public core::Transport {
 public:
  FakeTransport(std::shared_ptr<FakeNetwork> network, const FakeOptions& options)
      : node_(std::make_shared<FakeNode>(std::move(network), options)) {}
  ~FakeTransport() override { node_->closed = true; }

  std::size_t max_sample_bytes() const noexcept override { return node_->options.max_sample_bytes; }
  core::Availability poll(std::chrono::steady_clock::time_point) override {
    return core::Availability::ready;
  }
  std::string description() const override { return "within this process"; }

  Result<std::unique_ptr<core::WriterPort>> open_writer(const core::WriterSpec& spec) override {
    return std::make_unique<FakeWriter>(spec, node_);
  }
  Result<std::unique_ptr<core::ReaderPort>> open_reader(const core::ReaderSpec& spec) override {
    return std::make_unique<FakeReader>(spec, node_);
  }
  Counters counters() const noexcept override { return {.over_limit = node_->over_limit}; }

 private:
  const std::shared_ptr<FakeNode> node_;
};

}  // namespace

std::unique_ptr<core::Transport> open_fake_transport(std::shared_ptr<FakeNetwork> network,
                                                     const FakeOptions& options) {
  return std::make_unique<FakeTransport>(std::move(network), options);
}

}  // namespace sft::test
