#include "udp_transport/send/sender.h"

#include <sys/prctl.h>

#include <algorithm>

namespace sft::udp {

namespace {
constexpr unsigned long timer_slack_ns = 1000;  // the default slack would add 50 us to short pauses
}

Sender::Sender(std::unique_ptr<DatagramSender> io, std::uint64_t max_bytes_per_s)
    : io_(std::move(io)),
      limit_(max_bytes_per_s),
      scheduled_(*io_),
      flow_sender_(limit_, local_turns_, *io_, round_),
      lanes_(flow_sender_, scheduled_, round_),
      channels_(flow_sender_, round_) {}

Sender::~Sender() { stop(); }

Result<void> Sender::start(const core::ThreadSpec& thread, Hear hear) {
  flow_sender_.set_handler(std::move(hear));
  Result<std::thread> started = core::start_thread(thread, [this] { run(); });
  if (!started) return tl::unexpected<Error>(std::move(started.error()));
  thread_ = std::move(*started);
  return {};
}

void Sender::stop() {
  stopped_.store(true, std::memory_order_release);
  io_->wake();
  if (thread_.joinable()) thread_.join();
  scheduled_.close();
}

void Sender::run() {
  ::prctl(PR_SET_TIMERSLACK, timer_slack_ns);
  while (!stopped()) {
    round_.begin();
    flow_sender_.listen();
    scheduled_.carry_out_deferred();
    take_over_scheduled();
    lanes_.send_small();
    channels_.send_small();
    send_large();
    io_->await(round_.time());
    // Flows are removed only here, because await() may have waited for their connections.
    lanes_.forget_idle();
    channels_.forget_resting();
  }
  lanes_.clear();
  channels_.clear();
}

void Sender::take_over_scheduled() {
  scheduled_.take(taken_);
  for (std::shared_ptr<Lane>& lane : taken_.lanes) lanes_.add(std::move(lane));
  taken_.lanes.clear();
  for (std::shared_ptr<Channel>& channel : taken_.channels) channels_.add(std::move(channel));
  taken_.channels.clear();
}

int Sender::priority(std::size_t flow) const {
  return flow < lanes_.count() ? lanes_.priority(flow) : channels_.priority(flow - lanes_.count());
}

/// Sends a part of the large sample of each flow, of those with the greatest priority first. Each call begins
/// with a different flow, so that all flows get a first turn even if only a few can send. Deferred work is
/// carried out between the turns. It takes little time, since a deferred sample is small, or becomes a flow
/// itself.
void Sender::send_large() {
  const std::size_t count = lanes_.count() + channels_.count();
  if (count == 0) return;
  ++turn_;
  order_.clear();
  for (std::size_t i = 0; i < count; ++i) order_.push_back((turn_ + i) % count);
  const auto place = [&](std::size_t which) {
    return std::pair(-priority(which), (which + count - turn_ % count) % count);
  };
  if (!std::ranges::is_sorted(order_, {}, place)) std::ranges::sort(order_, {}, place);
  for (const std::size_t which : order_) {
    if (which < lanes_.count())
      lanes_.send_large(which);
    else
      channels_.send_large(which - lanes_.count());
    scheduled_.carry_out_deferred();
  }
}

}  // namespace sft::udp
