// `sft pub`: publishes messages that are written down.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tools/sft/message_type.h"
#include "tools/sft/session.h"

namespace sft::tool {

struct PubOptions {
  std::string topic{};
  TypeChoice type{};
  std::string value = "{}";         ///< YAML or JSON; "-": from the standard input, each once
  std::optional<double> rate_hz{};  ///< nothing: 1; of the standard input as fast as it comes
  std::uint64_t count = 0;          ///< 0: until it is stopped, or the input is at its end
  bool reliable = false;
  bool transient_local = false;
  std::optional<std::size_t> wait_for{};  ///< subscribers; nothing: 1 where it ends by itself, else 0
};

ExitCode run(const PubOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
