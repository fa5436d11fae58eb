// Connections to nowhere, for what only looks at who is connected to and what became of that.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "udp_transport/destination.h"

namespace sft::udp::test {

class Connections {
 public:
  DestinationDirectory::Connect connect() {
    return [this](const SocketAddress&) { return std::make_unique<Nowhere>(*this); };
  }
  std::size_t open() const { return open_; }
  std::size_t reconnected() const { return reconnected_; }
  const std::vector<SocketAddress>& redirected() const { return redirected_; }

 private:
  class Nowhere final : public Connection {
   public:
    explicit Nowhere(Connections& all) : all_(all) { ++all_.open_; }
    ~Nowhere() override { --all_.open_; }
    Sent try_send(std::span<const OutgoingBatch> batches) noexcept override { return {batches.size()}; }
    void reconnect() noexcept override { ++all_.reconnected_; }
    void redirect(const SocketAddress& to) noexcept override { all_.redirected_.push_back(to); }
    void wait_for_room() noexcept override {}
    bool full() const noexcept override { return false; }

   private:
    Connections& all_;
  };
  std::size_t open_ = 0;
  std::size_t reconnected_ = 0;
  std::vector<SocketAddress> redirected_;
};

}  // namespace sft::udp::test
