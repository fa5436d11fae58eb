// What is heard on all links, made into one: duplicates are dropped, an endpoint lives while any link has it
// alive, and the ids of endpoints, readers and nodes are bound to the participants that announced them first.
// Pure: (event, now) goes in, news come out. discovery.md has the rules.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/speakers.h"
#include "core/platform/clock.h"

namespace sft::core {

struct EndpointSeen {
  std::shared_ptr<const Endpoint> endpoint;
  /// Links by which its node was heard and is not any more, although it is by another one: the way there is
  /// cut, and samples would not arrive that way either.
  std::vector<LinkId> silent{};
};
struct EndpointDeparted {
  EndpointId id;
};
struct EndpointLost {
  EndpointId id;
};
struct NodeLost {
  NodeId id;
};
/// Somebody spoke in the name of somebody else, or too much.
struct Refused {
  std::string why;
};
using News =
    std::variant<EndpointSeen, EndpointDeparted, EndpointLost, Request, Assertion, NodeLost, Refused>;

class LinkMerge {
 public:
  struct Limits {
    std::size_t share = 256;     ///< announcements that each participant may have in any case
    std::size_t crowded = 8192;  ///< from so many announcements on a participant gets its share and no more
    std::size_t endpoints = 32'768;
    std::size_t early_requests = 1024;
    std::chrono::seconds forget_after{60};
  };

  LinkMerge() : LinkMerge(Limits{}) {}
  explicit LinkMerge(const Limits& limits) : limits_(limits) {}

  /// What others say of these ids is passed on as it is: the node answers it.
  void owns(EndpointId id) { own_.insert(id); }
  void disowns(EndpointId id) { own_.erase(id); }

  void endpoint_came(const Speaker& speaker, Endpoint endpoint, Time now);
  void endpoint_withdrawn(const Speaker& speaker, EndpointId id, Time now);
  /// Nobody on that link keeps the endpoint alive any more.
  void endpoint_unheard(LinkId link, EndpointId id, Time now);
  void request_came(const Speaker& speaker, Request request, Time now);
  void assertion_came(const Speaker& speaker, Assertion assertion, Time now);
  void node_unheard(LinkId link, NodeId id, Time now);
  void participant_left(const Speaker& speaker, Time now);
  void link_dropped(LinkId link, Time now);
  /// The same of a link that was made anew: what another link says of the same participants counts, though
  /// what came by the one that goes may be newer. That may have been somebody else's word.
  void replaced_link_dropped(LinkId link, Time now);
  void tick(Time now);

  /// The digests (control_digest.h) of all that is known here of each speaker's announcements.
  std::map<Speaker, std::uint32_t> digests() const;
  /// The name of that node, for people. Empty if no endpoint of it is known.
  std::string node_name(NodeId node) const;
  /// What came of that speaker is not what its node says. That does not count any more once another speaker
  /// of the node, or the same one on another link, is heard; and what was withdrawn may be there after all.
  void begin_anew(const Speaker& speaker);
  /// The same where all that its node says is known already from another speaker: that counts from now on.
  void disbelieve(const Speaker& speaker, Time now);
  /// Withdrawals may have been somebody else's: what was withdrawn may be there after all.
  void doubt_departures() { departed_.clear(); }

  /// In the order in which they happened.
  std::vector<News> take_news() { return std::exchange(news_, {}); }

 private:
  /// What one speaker says of an endpoint.
  struct Claim {
    Speaker speaker;
    std::shared_ptr<const Endpoint> endpoint;
    std::optional<Request> request{};  ///< the newest of its own
    bool alive = true;
    Time ended{};                           ///< when it was alive last, if it is not
    std::optional<Time> contested_since{};  ///< it says something else than the one that is believed
    bool refused = false;
    bool untrue = false;  ///< by a link that is made anew: it counts as long as there is no other one
  };
  struct Known {
    std::vector<Claim> claims;  ///< the first one first, but those that are untrue are last
    /// The believed speaker does not say that its node lives, while another one does.
    std::optional<Time> doubted_since{};
    std::vector<LinkId> told_silent;       ///< with it
    std::shared_ptr<const Endpoint> told;  ///< what was passed on last
    std::uint64_t told_request = 0;        ///< sequence
    std::optional<Time> lost_at{};         ///< nobody keeps it alive
    bool lost = false;                     ///< and that was told
    std::optional<Time> true_from{};       ///< then what a link that is made anew says counts in any case
    bool told_untrue = false;              ///< what was told may be somebody else's word
  };
  struct Departed {
    std::uint64_t revision;
    Time at;
  };
  struct EarlyRequest {
    Speaker speaker;
    Request request;
    Time at;
  };
  struct NodeClaim {
    Speaker speaker;
    bool alive = true;
  };
  struct KnownNode {
    std::vector<NodeClaim> claims;
    std::optional<Time> lost_at{};
    bool lost = false;
  };

  static std::chrono::milliseconds lease_of(const Known& known);
  std::chrono::milliseconds lease_of(NodeId node) const;
  bool has_room_for(const Speaker& speaker);
  Claim* claim_of(Known& known, const Speaker& speaker) const;
  Claim* believed(Known& known, Time now) const;
  bool may_be_believed(const Known& known, const Claim& claim, Time now) const;
  static NodeId node_of(const Known& known);
  void hear_claim(Known& known, const Speaker& speaker, std::shared_ptr<const Endpoint> endpoint, Time now);
  void adopt_early_request(Claim& claim);
  void compare_claims(Known& known, Time now);
  void refuse_contested(Known& known, Time now);
  bool is_vouched_for(const Claim& claim) const;
  void prefer_vouched(Known& known, Time now);
  void end_claim(Claim& claim, Time now);
  void settle(EndpointId id, Known& known, Time now);
  void settle_node(NodeId id, KnownNode& node, Time now);
  void end_silent_claims(NodeId id, KnownNode& node, Time now) const;
  std::vector<LinkId> silent_links(const Known& known, const Claim& believed, Time now) const;
  void tell(Known& known, const Claim& claim);
  void depart(EndpointId id, Time now);
  static std::uint64_t asked(const Claim& claim);
  static bool is_open_what_is_true(Known& known, const Claim& claim, Time now);
  void take_back_if_untrue(Known& known, const Claim& claim);
  void refuse(const std::string& why) { news_.emplace_back(Refused{why}); }
  void forget_old(Time now);
  void drop_claims(Known& known, LinkId link);

  const Limits limits_;
  std::set<EndpointId> own_;
  std::set<Speaker> disbelieved_;  ///< on links that go soon
  std::map<EndpointId, Known> endpoints_;
  std::map<EndpointId, Departed> departed_;
  std::vector<EarlyRequest> early_requests_;
  std::map<NodeId, KnownNode> nodes_;
  std::map<AnnouncerId, std::size_t> shares_;  ///< claims of each participant
  std::size_t claims_ = 0;
  Speakers speakers_;
  std::vector<News> news_;
};

}  // namespace sft::core
