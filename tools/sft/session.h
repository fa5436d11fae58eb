// The node with which a command observes a domain.
#pragma once

#include <sft/sft.h>
#include <functional>
#include <optional>
#include <string>

#include "tools/sft/common_options.h"
#include "tools/sft/exit_code.h"
#include "tools/sft/output.h"
#include "tools/terminal/stop.h"

namespace sft::tool {

/// A topic that some node publishes or subscribes to, and its type.
struct FoundTopic {
  std::string name;
  DynamicType type;
  Qos requested;  ///< the strongest QoS that all of its publishers offer
};

class Session {
 public:
  /// `command` is a part of the node's name. Only the node of `perf` may start a daemon, as programs do: a
  /// command that observes must not change the host.
  static Result<Session> open(const CommonOptions& options, std::string_view command, Stop& stop,
                              Output& output);

  Node& node() { return node_; }
  Stop& stop() { return *stop_; }
  Output& output() { return *output_; }
  const CommonOptions& options() const { return options_; }

  /// Waits for options.wait_s, so that other nodes are found, and returns domain().
  DomainSnapshot look_around();
  /// Returns the domain as it is known now, without the publishers and subscribers of this session.
  DomainSnapshot domain() const;

  /// Waits until `enough` is true for the domain, at most for `for_s`. Returns false if the time is over.
  bool wait_until(const std::function<bool(const DomainSnapshot&)>& enough, double for_s);
  /// The same, for options.timeout_s.
  bool wait_until(const std::function<bool(const DomainSnapshot&)>& enough) {
    return wait_until(enough, options_.timeout_s);
  }

  /// Returns the name without its leading slash, which has no meaning.
  static std::string plain_name(std::string_view topic);
  /// Returns the name under which nodes announce a topic that the user wrote with or without a leading slash;
  /// nothing while no node publishes or subscribes to it.
  static std::optional<std::string> known_name(std::string_view topic, const DomainSnapshot& domain);

  /// Returns an error if the topic is private to a node, "~/image": a command takes topics by their full
  /// names.
  Result<void> check_name(std::string_view topic);
  /// Adds to an error about an unknown topic which topics programs call by that name.
  Error explained(Error error, std::string_view topic) const;

  /// Finds a topic and its type. Errc::unavailable if no node announces the topic within the timeout. If its
  /// nodes announce a type without its fields, the definition comes from files (CommonOptions::includes).
  Result<FoundTopic> find(std::string_view topic);
  /// Returns the name under which nodes announce the topic, if they announce its type without fields;
  /// otherwise nothing.
  std::optional<std::string> undescribed(std::string_view topic) const;

 private:
  Session(Node node, const CommonOptions& options, Stop& stop, Output& output)
      : node_(std::move(node)), options_(options), stop_(&stop), output_(&output) {}

  Node node_;
  CommonOptions options_;
  Stop* stop_;
  Output* output_;
};

/// The part of an error that explains why a host which --peer names is not found.
inline constexpr const char* peers_name_each_other =
    "nodes on the host that --peer names have to name this host as a peer, too (DiscoverySettings::peers)";

/// Prints the error, and returns its exit code.
ExitCode give_up(const Error& error);

}  // namespace sft::tool
