// Telling a service manager how far this service is: systemd's protocol, one datagram for each piece of news.
// A library for that would be more than what it does.
#pragma once

#include <string>
#include <string_view>

namespace sft::shm {

class ServiceManager {
 public:
  /// `socket`: what it put into NOTIFY_SOCKET; empty if there is none.
  explicit ServiceManager(std::string socket) : socket_(std::move(socket)) {}

  void ready(const std::string& status) const { tell("READY=1\nSTATUS=" + status); }
  void stopping() const { tell("STOPPING=1"); }

 private:
  /// Nothing is to be done where nobody listens.
  void tell(std::string_view news) const;
  std::string socket_;
};

}  // namespace sft::shm
