// Notifies a service manager when this service is ready and when it stops. The protocol is that of systemd:
// one datagram for each message. A library for this protocol would be larger than this code.
#pragma once

#include <string>
#include <string_view>

namespace sft::shm {

class ServiceManager {
 public:
  /// `socket` is the value of the environment variable NOTIFY_SOCKET; empty if there is no service manager.
  explicit ServiceManager(std::string socket) : socket_(std::move(socket)) {}

  void ready(const std::string& status) const { send("READY=1\nSTATUS=" + status); }
  void stopping() const { send("STOPPING=1"); }

 private:
  /// Sends one message. Ignores all errors, because the daemon serves programs even if no service manager
  /// listens.
  void send(std::string_view message) const;
  std::string socket_;
};

}  // namespace sft::shm
