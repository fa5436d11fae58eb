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
  /// Opens the node. `command` is a part of the node's name. Only the node of `perf` may start a daemon, as
  /// programs do. A command that only observes must not change the host.
  static Result<Session> open(const CommonOptions& options, std::string_view command, Stop& stop,
                              Output& output);

  Node& node() { return node_; }
  Stop& stop() { return *stop_; }
  Output& output() { return *output_; }
  const CommonOptions& options() const { return options_; }

  /// Waits for options.wait_s, so that other nodes are discovered, and returns domain().
  DomainSnapshot look_around();
  /// Returns the domain as it is known at present, without the publishers and subscribers of this session.
  DomainSnapshot domain() const;

  /// Waits until `enough` is true for the domain, at most for `for_s`. Returns false if this has not
  /// happened within `for_s` seconds.
  bool wait_until(const std::function<bool(const DomainSnapshot&)>& enough, double for_s);
  /// Waits in the same way, but for options.timeout_s.
  bool wait_until(const std::function<bool(const DomainSnapshot&)>& enough) {
    return wait_until(enough, options_.timeout_s);
  }

  /// Returns the name without a leading slash, because the slash has no meaning.
  static std::string plain_name(std::string_view topic) {
    return std::string(topic.starts_with('/') ? topic.substr(1) : topic);
  }
  /// Returns the name under which nodes announce a topic that the user has written with or without a leading
  /// slash. Returns nothing while no node publishes or subscribes to the topic.
  static std::optional<std::string> known_name(std::string_view topic, const DomainSnapshot& domain);

  /// Returns an error if the topic is private to a node, such as "~/image", since commands need the full
  /// names of topics.
  Result<void> check_name(std::string_view topic);
  /// Extends an error about an unknown topic: adds the full names of topics whose programs use the name
  /// `topic` before remapping.
  Error explained(Error error, std::string_view topic) const;

  /// Finds a topic and its type. The error is Errc::unavailable if no node announces the topic within the
  /// timeout. If its nodes announce a type without its fields, the definition is read from files
  /// (CommonOptions::includes).
  Result<FoundTopic> find(std::string_view topic);
  /// Returns the name under which nodes of SFT announce the topic, if none of them announces the fields of
  /// its type. Otherwise returns nothing.
  std::optional<std::string> undescribed(std::string_view topic) const;

 private:
  Session(Node node, const CommonOptions& options, Stop& stop, Output& output)
      : node_(std::move(node)), options_(options), stop_(&stop), output_(&output) {}

  Node node_;
  CommonOptions options_;
  Stop* stop_;
  Output* output_;
};

/// Returns the durability that a subscriber may request of that publisher. DDS gives retained samples to
/// reliable readers only, and these match reliable writers only.
Durability requestable_durability(const DomainSnapshot::Endpoint& publisher);

/// Waits for a moment if the publisher serves readers of DDS. Such a reader discovers the publisher later
/// than the publisher discovers the reader, and misses samples that are published in between, unless they
/// are retained.
void await_dds_readers(const DynamicPublisher& publisher, Stop& stop);

/// The part of an error that explains why a host that --peer names is not found.
inline constexpr const char* peers_name_each_other =
    "nodes on the host that --peer names have to name this host as a peer, too (DiscoverySettings::peers)";

/// Prints the error, and returns its exit code.
ExitCode give_up(const Error& error);

}  // namespace sft::tool
