// A publisher's way onto the wire: one encoding for each distinct
// mask, sent from its own thread while it is small.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/buffer_pool.h"
#include "core/transport.h"
#include "udp_transport/routes.h"
#include "udp_transport/sender.h"

namespace sft::udp {

/// What the writers of one transport share. Outlives the transport as long as a writer does.
struct SendSide {
  SendSide(std::unique_ptr<DatagramSender> io, const DestinationLimits& limits)
      : sender(std::move(io)), destinations(limits) {}

  Sender sender;
  DestinationDirectory destinations;
  std::shared_ptr<core::BufferPool> pool;
  std::size_t max_sample_bytes = 0;  ///< of a body
  std::size_t queue_depth = 0;
  std::atomic<std::uint64_t> over_limit{0};
};

class UdpWriter final : public core::WriterPort {
 public:
  UdpWriter(const core::WriterSpec& spec, std::shared_ptr<SendSide> side);

  core::SampleHandle loan(std::size_t bytes) noexcept override;
  core::SendStatus send(const core::SampleHandle& sample) noexcept override;
  void set_routes(std::vector<core::Route> routes) override;
  void send_history(const core::Route& to, std::vector<core::SampleHandle> samples) override;
  bool history_sent() const noexcept override {
    return tally_->history_waiting.load(std::memory_order_relaxed) == 0;
  }
  std::uint64_t bytes_sent() const noexcept override;

 private:
  void follow_routes() noexcept;
  bool send(const Group& group, const core::SampleHandle& sample) noexcept;
  bool encode(const Group& group, const core::SampleBuffer& sample, Job& job);
  bool send_at_once(const Audience& audience, Job& job, bool& lossless) noexcept;
  bool enqueue(const Group& group, const core::SampleHandle& sample, Job& job);

  const std::uint32_t writer_;  ///< low half of the id
  const TypeSupport& type_;
  const std::shared_ptr<SendSide> side_;
  const std::shared_ptr<WriterTally> tally_;

  // Of the agent's thread.
  VariantDirectory variants_;

  // From the agent's thread to the publisher's.
  std::mutex routes_mutex_;
  std::shared_ptr<const RouteTable> latest_routes_;
  std::atomic<std::uint64_t> routes_version_{0};

  // Of the publisher's thread.
  std::shared_ptr<const RouteTable> routes_;
  std::uint64_t followed_version_ = 0;
  Batch batch_;
};

}  // namespace sft::udp
