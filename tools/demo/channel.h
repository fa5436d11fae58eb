// The connection between the demo and each of its processes: JSON messages over a pair of sockets. If
// either side ends, the connection is closed, so that the other side notices it.
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"
#include "tools/terminal/stop.h"

template <class T>
struct nlohmann::adl_serializer<std::optional<T>> {
  static void to_json(json& j, const std::optional<T>& value) { j = value ? json(*value) : json(nullptr); }
  static void from_json(const json& j, std::optional<T>& value) {
    value = j.is_null() ? std::nullopt : std::optional(j.get<T>());
  }
};

namespace sft::demo {

using Clock = std::chrono::steady_clock;

class Channel {
 public:
  /// Both ends are closed on exec, but not on fork: see hosts::close_descriptors_except().
  static Result<std::pair<Channel, Channel>> make_pair();

  /// Returns false if the other side is gone.
  bool send(const nlohmann::json& message);
  /// Waits until the deadline, and returns true at once if receive() does not have to wait any more.
  bool readable_before(Clock::time_point deadline);
  /// Waits for the next message. Returns nothing if the other side is gone.
  std::optional<nlohmann::json> receive();

  int descriptor() const { return socket_.get(); }

 private:
  explicit Channel(core::FileDescriptor socket) : socket_(std::move(socket)) {}

  core::FileDescriptor socket_;
};

inline constexpr const char* stopped_early = "stopped before anything was published, so there are no figures";

/// Sends an order, which may be empty, and waits for the answer. `role` names the other side in errors.
/// Returns an error if the user requests a stop. If `stop` is null, the user cannot end the wait.
Result<nlohmann::json> ask(Channel& channel, std::string_view role, std::string_view order,
                           Clock::duration timeout, tool::Stop* stop);

/// Answers the next order with the error. Called by a role that cannot continue.
void refuse(Channel& channel, const Error& error);

}  // namespace sft::demo
