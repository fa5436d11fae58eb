// The routes of the bridges of one domain, by which each sample comes there once.
//
// A publisher that was not made by a bridge is an origin. A bridge that takes its samples to another domain
// announces a route: the origin, the topic there, and the number of bridges that the samples have passed by
// then. Each bridge announces its routes on the topic "sft_bridges" of the domain that the samples are taken
// to. The bridge also announces there the DDS writers that it hears in that domain, whose samples have passed
// no bridge. Of all routes with the same origin and topic, the one with the fewest bridges is used, and of
// equal ones that of the bridge that was started first. The other bridges wait. So samples are not multiplied
// by rings of bridges, or by bridges side by side. When the route in use is gone, the next one is used.
#pragma once

#include <sft/sft.h>
#include <chrono>
#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace sft::tool {

/// The beginning of the names of nodes of bridges.
inline constexpr const char* bridge_node_prefix = "sft_bridge_";
/// The topic of the routes.
inline constexpr const char* bridge_topic = "sft_bridges";

class BridgeRoutes {
 public:
  using Time = std::chrono::steady_clock::time_point;
  struct Route {
    std::uint64_t origin = 0;
    std::uint32_t bridges = 0;    ///< that the samples have passed; 0: the origin is in this domain
    std::string topic{};          ///< in this domain
    std::uint64_t publisher = 0;  ///< the bridge's publisher; 0: none, the route is not in use yet
    auto operator<=>(const Route&) const = default;
  };
  /// The origin of the samples of a publisher, and the number of bridges that they have passed.
  struct Source {
    std::uint64_t origin = 0;
    std::uint32_t bridges = 0;
  };
  enum class Verdict : std::uint8_t { holds, settles, belongs_there, held_by_another };

  /// `bridge` is the number of this bridge, the time at which it was started.
  static Result<BridgeRoutes> open(Node& node, std::uint64_t bridge);

  /// Takes the routes of other bridges, and forgets bridges that are gone. What they announce is bounded, and
  /// counts only while their publishers are there.
  void look(const DomainSnapshot& domain, Time now);
  /// Returns nothing for the publisher of a bridge that has not announced the route yet.
  std::optional<Source> source_of(const DomainSnapshot::Endpoint& publisher) const;
  /// Decides whether samples may be carried here.
  Verdict verdict(const Source& source, const std::string& topic, Time now) const;
  /// Announces the routes of this bridge if they have changed, and from time to time if they have not:
  /// another sender may have forged an announcement in the name of this bridge.
  void announce(std::vector<Route> routes, Time now);

 private:
  struct Other {
    std::uint64_t bridge = 0;
    std::uint64_t node = 0;  ///< the node of its publisher; 0: the publisher has not been seen yet
    std::vector<Route> routes{};
    Time heard{};
    Time seen{};            ///< when its publisher was last there
    bool is_there = false;  ///< false: its routes hold again when it comes back, as after an outage
  };
  BridgeRoutes(std::uint64_t bridge, DynamicPublisher publisher, DynamicSubscriber subscriber)
      : bridge_(bridge),
        publisher_(std::move(publisher)),
        subscriber_(std::move(subscriber)),
        own_id_(publisher_.status().id) {}
  Result<void> publish(const std::vector<Route>& routes);
  void hear(Time now);
  void forget(Time now);
  bool is_settled(const Source& source, const std::string& topic, Time now) const;

  std::uint64_t bridge_;
  DynamicPublisher publisher_;
  DynamicSubscriber subscriber_;
  std::uint64_t own_id_;                     ///< the id of `publisher_`, which the subscriber hears, too
  std::map<std::uint64_t, Other> others_{};  ///< by the id of their publisher
  std::map<std::uint64_t, Time> unheard_{};  ///< and since when they are known
  std::set<std::uint64_t> publishers_{};     ///< all of the domain
  std::vector<Route> announced_{};           ///< the routes that this bridge has announced, sorted
  Time announced_again_at_{};                ///< when they are announced again
  std::map<std::pair<std::uint64_t, std::string>, Time> since_{};  ///< when each route was first announced
  Time opened_ = std::chrono::steady_clock::now();
};

}  // namespace sft::tool
