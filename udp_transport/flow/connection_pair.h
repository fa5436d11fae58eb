// The connections to one remote socket: one for what is small, and another one for large samples, so that
// small ones do not queue behind these.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>

#include "udp_transport/flow/remote_path.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/wire/fragmenter.h"

namespace sft::udp {

using Connect = std::function<std::unique_ptr<Connection>(const SocketAddress&)>;

class ConnectionPair {
 public:
  /// `connect` is called now, and again for the first large sample.
  ConnectionPair(Connect connect, const SocketAddress& to);

  // Any thread.

  Connection& small() { return *small_; }
  /// The connection for large samples; null before the first.
  Connection* bulk_in_use() { return bulk_in_use_.load(std::memory_order_acquire); }
  /// Returns the connection that is behind everything that was sent.
  Connection& last_in_line() {
    Connection* const bulk = bulk_in_use();
    return bulk == nullptr ? *small_ : *bulk;
  }
  /// Looks for the way anew: after a refusal, or for other routes and own addresses.
  void reconnect() noexcept;
  void redirect(const SocketAddress& to) noexcept;

  std::size_t datagrams_per_call() const {
    return one_at_a_time_.load(std::memory_order_relaxed) ? 1 : batch_datagrams_max;
  }
  /// The way out takes one datagram at a time only (SendOutcome::no_segments), until there is another one.
  void take_one_at_a_time() noexcept { one_at_a_time_.store(true, std::memory_order_relaxed); }

  // The sending thread.

  /// The connection for large samples. The first call makes it.
  Connection& bulk(const RemotePath& path);

 private:
  const Connect connect_;
  std::atomic<bool> one_at_a_time_{false};
  const std::unique_ptr<Connection> small_;
  std::unique_ptr<Connection> bulk_;  ///< used by the sending thread; other threads use `bulk_in_use_`
  std::atomic<Connection*> bulk_in_use_{nullptr};
};

}  // namespace sft::udp
