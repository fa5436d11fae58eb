// The node by which a command looks at a domain.
#pragma once

#include <sft/sft.h>
#include <functional>
#include <optional>
#include <string>

#include "tools/sft/common_options.h"
#include "tools/sft/exit_code.h"
#include "tools/sft/output.h"
#include "tools/sft/stop.h"

namespace sft::tool {

/// A topic that somebody publishes or subscribes to, and its type.
struct FoundTopic {
  std::string name;
  DynamicType type;
  Qos requested;  ///< the most that all of its publishers offer
};

class Session {
 public:
  /// `command` is a part of the node's name. The node never starts a daemon: looking changes nothing.
  static Result<Session> open(const CommonOptions& options, std::string_view command, Stop& stop,
                              Output& output);

  Node& node() { return node_; }
  Stop& stop() { return *stop_; }
  Output& output() { return *output_; }

  /// Looks around for as long as the options say. Own publishers and subscribers are left out.
  DomainSnapshot look_around();
  DomainSnapshot domain() const;

  /// Waits until `enough` holds of the domain, for so long at most; tells whether it does.
  bool wait_until(const std::function<bool(const DomainSnapshot&)>& enough, double for_s);
  /// As long as the user lets it look for a topic.
  bool wait_until(const std::function<bool(const DomainSnapshot&)>& enough) {
    return wait_until(enough, options_.timeout_s);
  }

  /// Without a slash in front, which counts for nothing.
  static std::string plain_name(std::string_view topic);
  /// The name under which nodes know a topic that a user names: with or without a slash in front. Nothing
  /// while nobody publishes or subscribes to it.
  static std::optional<std::string> known_name(std::string_view topic, const DomainSnapshot& domain);

  /// Errc::unavailable if it does not show up in time.
  Result<FoundTopic> find(std::string_view topic);

 private:
  Session(Node node, const CommonOptions& options, Stop& stop, Output& output)
      : node_(std::move(node)), options_(options), stop_(&stop), output_(&output) {}

  Node node_;
  CommonOptions options_;
  Stop* stop_;
  Output* output_;
};

/// Says what went wrong, and returns the exit code for it.
ExitCode give_up(const Error& error);

}  // namespace sft::tool
