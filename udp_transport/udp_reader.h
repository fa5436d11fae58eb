// The side of the UDP transport that serves one subscriber.
#pragma once

#include <memory>
#include <vector>

#include "core/seam/transport.h"
#include "udp_transport/receive/inbox.h"
#include "udp_transport/receive/receive_loop.h"

namespace sft::udp {

class UdpReader final : public core::NetworkReader {
 public:
  UdpReader(const core::ReaderSpec& spec, std::shared_ptr<ReceiveLoop> receiver);
  /// Waits until a running call of the listener has returned, unless that call destroys the reader.
  ~UdpReader() override;

  core::SampleHandle take() noexcept override { return inbox_->take(); }
  Result<void> connect(const core::Source& source) override;
  bool connected(core::EndpointId writer) const noexcept override { return inbox_->connected(writer); }
  core::HistoryProgress history(core::EndpointId writer) const noexcept override {
    return inbox_->history(writer);
  }
  std::uint64_t arrivals(core::EndpointId writer) noexcept override { return inbox_->arrivals(writer); }
  void announced(const core::Source& source) override;
  void disconnect(core::EndpointId writer) noexcept override;
  bool receive(const core::Waiting& waiting) noexcept override { return receiver_->receive(waiting); }
  void share_reader() override;
  void accept(std::vector<core::Accepted> accepted) override;
  Counters counters() const noexcept override { return {inbox_->discarded(), inbox_->lost_unnoticed()}; }

 private:
  core::ReaderSpec spec_;
  const std::shared_ptr<ReceiveLoop> receiver_;
  const std::shared_ptr<Inbox> inbox_;
};

}  // namespace sft::udp
