// A publisher's way onto the wire: one encoding for each distinct mask, sent from its own thread while it is
// small.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/snapshot.h"
#include "core/transport.h"
#include "udp_transport/routes.h"
#include "udp_transport/sender.h"

namespace sft::udp {

/// What the writers of one transport share. Outlives the transport as long as a writer does.
struct SendSide {
  SendSide(std::unique_ptr<DatagramSender> io, const DestinationLimits& limits)
      : sender(std::move(io)),
        destinations(limits, [this](const SocketAddress& to) { return sender.connect(to); }) {}

  Sender sender;
  DestinationDirectory destinations;
  std::size_t max_sample_bytes = 0;  ///< of a body
  std::size_t queue_depth = 0;
  std::atomic<std::uint64_t> over_limit{0};
};

class UdpWriter final : public core::WriterPort {
 public:
  UdpWriter(const core::WriterSpec& spec, std::shared_ptr<SendSide> side);

  core::SendStatus send(const core::SampleHandle& sample) noexcept override;
  void begin() noexcept override;
  void miss() noexcept override;
  void count_in(std::shared_ptr<core::DeliveryBook> book) override { book_ = std::move(book); }
  void set_routes(std::vector<core::Route> routes) override;
  void send_history(const core::Route& to, std::vector<core::SampleHandle> samples) override;
  bool history_sent() const noexcept override;
  std::uint64_t bytes_sent() const noexcept override;
  std::uint64_t dropped() const noexcept override;

 private:
  const RouteTable& routes_of_sample() noexcept;
  void turn_to(const RouteTable& routes) noexcept;
  bool send(const Group& group, const core::SampleHandle& sample) noexcept;
  bool encode(const ProjectionPlan& plan, const std::shared_ptr<const WireMask>& wire,
              const core::SampleBuffer& sample, Job& job);
  SendOutcome try_send(Destination& to, const EncodedBody& body);
  std::shared_ptr<Lane> lane_of(const Group& group, const core::Route& route);
  bool enqueue(const std::shared_ptr<Lane>& lane);

  const std::uint32_t writer_;  ///< low half of the id
  const TypeSupport& type_;
  const std::shared_ptr<SendSide> side_;
  const std::shared_ptr<WriterTally> tally_;

  VariantDirectory variants_;  ///< of the agent's thread
  core::Snapshot<RouteTable> routes_;
  std::shared_ptr<core::DeliveryBook> book_;  ///< null: nobody asks what became of samples

  // Of the publisher's thread.
  const RouteTable* in_use_ = nullptr;  ///< of the last sample; whose page is open
  bool begun_ = false;                  ///< they are those of the present one
  const std::shared_ptr<JobPool> jobs_;
  JobHandle blank_;          ///< the next job, empty if a lane has the last
  Batch batch_;              ///< of the present sample
  std::size_t cut_for_ = 0;  ///< bytes of the datagrams in the batch; 0: none of the present sample
};

}  // namespace sft::udp
