#include "udp_transport/flow/connection_pair.h"

#include <utility>

namespace sft::udp {

ConnectionPair::ConnectionPair(Connect connect, const SocketAddress& to)
    : connect_(std::move(connect)), small_(connect_(to)) {}

void ConnectionPair::reconnect() noexcept {
  small_->reconnect();
  if (Connection* const bulk = bulk_in_use()) bulk->reconnect();
}

void ConnectionPair::redirect(const SocketAddress& to) noexcept {
  small_->redirect(to);
  one_at_a_time_.store(false, std::memory_order_relaxed);
  if (Connection* const bulk = bulk_in_use()) bulk->redirect(to);
}

/// Returns the connection for large samples, and makes it if it does not exist. The remote socket may move
/// to another address while the connection is made. redirect() does not change the new connection then, so
/// the address is checked again.
Connection& ConnectionPair::bulk(const RemotePath& path) {
  if (bulk_ == nullptr) {
    const SocketAddress to = path.address();
    bulk_ = connect_(to);
    bulk_->carry_bulk();
    bulk_in_use_.store(bulk_.get(), std::memory_order_release);
    if (const SocketAddress now = path.address(); now != to) bulk_->redirect(now);
  }
  return *bulk_;
}

}  // namespace sft::udp
