// The side of the UDP transport that serves one publisher. It makes one encoding of each sample for each
// distinct mask. If the encodings are small and few, the publisher's thread sends them itself.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/seam/transport.h"
#include "core/sync/published.h"
#include "udp_transport/routing/routes.h"
#include "udp_transport/send/fan_out.h"
#include "udp_transport/send/send_side.h"
#include "udp_transport/send/variant_sender.h"

namespace sft::udp {

class UdpWriter final : public core::NetworkWriter, private Periodic {
 public:
  UdpWriter(const core::WriterSpec& spec, std::shared_ptr<SendSide> side);
  ~UdpWriter() override;

  core::SendStatus send(const core::SampleHandle& sample) noexcept override;
  void set_timeout(std::chrono::nanoseconds at_most) noexcept override { timeout_max_ = at_most; }
  void set_routes(std::vector<core::Route> routes) override;
  bool takes_postponed() const noexcept override { return true; }
  void begin_local_turn() noexcept override { side_->sender.local_turns().begin(); }
  void end_local_turn() noexcept override { side_->sender.local_turns().end(); }
  void send_history(const core::Route& to, std::vector<core::SampleHandle> samples) override;
  bool history_sent(core::EndpointId reader) noexcept override;
  Counters counters() const noexcept override;
  std::string multicast(core::EndpointId reader) const override { return keeper_.why(reader); }
  std::string path_trouble(core::EndpointId reader) const override;

 private:
  void begin_sample() noexcept override;
  core::SendStatus send_begun(const core::SampleHandle& sample, core::Reach reach) noexcept override;
  void miss_begun() noexcept override;
  void hold(core::BatchTimeout timeout) noexcept override;
  std::size_t flush() noexcept override;
  Time maintain(Time now) override;
  void make_table();
  void announce_to_receivers(const RouteTable& table);
  std::size_t own_variants(const core::SampleBuffer& sample) const noexcept;
  std::size_t hold_or_send(const Audience& group, const core::SampleHandle& sample) noexcept;
  void send_held() noexcept { missed_ += sender_.flush(); }
  bool defer(const core::SampleHandle& sample, std::size_t first, std::size_t end) noexcept;
  static void count_missed(std::span<const Audience> groups) noexcept;
  void turn_to(const RouteTable& routes) noexcept;

  std::chrono::nanoseconds timeout() const noexcept { return std::min(max_blocking_, timeout_max_); }

  const TypeSupport& type_;
  const std::chrono::nanoseconds max_blocking_;
  const std::shared_ptr<SendSide> side_;
  const std::shared_ptr<WriterTally> tally_;
  const std::shared_ptr<JobPool> jobs_;

  ChannelDirectory channels_;           ///< used by the agent's thread
  VariantDirectory variants_;           ///< used by the agent's thread
  GroupKeeper keeper_;                  ///< used by the agent's thread
  std::vector<core::Route> asked_for_;  ///< the routes as they were set; used by the agent's thread
  core::Published<RouteTable> routes_;
  /// Counts deliveries per reader; null if that is not needed.
  const std::shared_ptr<core::DeliveryBook> book_;

  // The following members are used by the publisher's thread.
  std::chrono::nanoseconds timeout_max_ = std::chrono::nanoseconds::max();
  const RouteTable nobody_;
  const RouteTable* in_use_ = &nobody_;  ///< table of the latest sample; its page of counts is open
  /// Says if the sending thread still has samples to be counted in the previous page.
  core::DeliveryBook::LateCounts late_counts_{};
  VariantSender sender_;
  bool holds_ = false;      ///< true between the calls of hold() and flush()
  std::size_t missed_ = 0;  ///< number of held samples that some reader missed
  /// The table of the held samples, which keeps their audiences alive.
  std::shared_ptr<const RouteTable> held_for_;
  const std::shared_ptr<FanOut> deferred_;
};

}  // namespace sft::udp
