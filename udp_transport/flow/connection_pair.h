// The connections to one remote socket: one for small samples and control, and one for large samples. So
// small datagrams do not wait in a send buffer until large samples have left.
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
  /// Calls `connect` now, and again when the first large sample is sent.
  ConnectionPair(Connect connect, const SocketAddress& to);

  // Any thread may call the following functions.

  Connection& small() { return *small_; }
  /// Returns the connection for large samples; null until the first large sample is sent.
  Connection* bulk_in_use() { return bulk_in_use_.load(std::memory_order_acquire); }
  /// Returns the connection whose next datagram leaves after all datagrams sent so far.
  Connection& last_in_line() {
    Connection* const bulk = bulk_in_use();
    return bulk == nullptr ? *small_ : *bulk;
  }
  /// Looks up the path again. Called after a refusal, or when routes or our own addresses have changed.
  void reconnect() noexcept;
  void redirect(const SocketAddress& to) noexcept;

  std::size_t datagrams_per_call() const {
    return one_at_a_time_.load(std::memory_order_relaxed) ? 1 : batch_datagrams_max;
  }
  /// From now on, sends only one datagram per call, until redirect(). Called if the interface cannot segment
  /// (SendOutcome::no_segments).
  void take_one_at_a_time() noexcept { one_at_a_time_.store(true, std::memory_order_relaxed); }

  // The following functions are for the sending thread only.

  /// Returns the connection for large samples. The first call makes it.
  Connection& bulk(const RemotePath& path);

 private:
  const Connect connect_;
  std::atomic<bool> one_at_a_time_{false};
  const std::unique_ptr<Connection> small_;
  std::unique_ptr<Connection> bulk_;  ///< used by the sending thread; all other threads use `bulk_in_use_`
  std::atomic<Connection*> bulk_in_use_{nullptr};
};

}  // namespace sft::udp
