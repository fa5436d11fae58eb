// The claims of several speakers about one endpoint, and which of them is believed. Pure: events and times go
// in, news come out. discovery.md has the rules.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/claim.h"
#include "core/discovery/claim_counts.h"
#include "core/discovery/discovery_news.h"
#include "core/discovery/node_claims.h"
#include "core/discovery/speakers.h"
#include "core/discovery/told_endpoint.h"
#include "core/platform/clock.h"

namespace sft::core {

/// Shared by the claims of all endpoints.
struct ClaimContext {
  const Speakers& speakers;
  const NodeClaims& nodes;
  ClaimCounts& counts;
  std::vector<News>& news;

  void refuse(const std::string& why) const { news.emplace_back(Refused{why}); }
};

class EndpointClaims {
 public:
  /// The context outlives this object.
  explicit EndpointClaims(const ClaimContext& context) : context_(context), told_(context.news) {}
  ~EndpointClaims();
  EndpointClaims(const EndpointClaims&) = delete;
  EndpointClaims& operator=(const EndpointClaims&) = delete;

  bool is_announced_by(const Speaker& speaker) const;
  /// False if the endpoint belongs to another node than this announcement says, and the speaker itself has
  /// said otherwise before. Refuses each announcement by another node.
  bool accepts(const Speaker& speaker, const Endpoint& endpoint) const;

  /// A speaker announces the endpoint for the first time. `is_disbelieved`: by a link that is made anew.
  void add(const Speaker& speaker, std::shared_ptr<const Endpoint> endpoint,
           std::optional<Request> early_request, bool is_disbelieved, Time now);
  /// One of the speakers announces the endpoint anew.
  void announced(const Speaker& speaker, std::shared_ptr<const Endpoint> endpoint, Time now);
  /// One of the speakers withdraws the endpoint. Returns true if the endpoint has departed. Otherwise only
  /// this speaker does not announce it any more.
  bool withdrawn(const Speaker& speaker, Time now);
  /// One of the speakers tells a request.
  void requested(const Speaker& speaker, Request request, Time now);

  /// Nobody on that link keeps the endpoint alive any more.
  void unheard(LinkId link, Time now);
  void participant_departed(const Speaker& speaker, Time now);
  void link_dropped(LinkId link, Time now);
  /// Called before link_dropped(), if the link was made anew: what another link says of the same participants
  /// counts, although what came by this link may be newer. That may have been somebody else's word.
  void link_is_replaced(LinkId link, Time now);
  void tick(Time now);

  /// The claim of that speaker does not count any more once another speaker is heard.
  void begin_anew(const Speaker& speaker);
  /// Another speaker counts from now on, if what was told may be somebody else's word.
  void trust_others(Time now);

  const ToldEndpoint& told() const { return told_; }
  /// What one of the speakers announces.
  const Endpoint& announced_by(const Speaker& speaker) const;
  /// Calls use(claim) for each claim that is alive.
  template <class Use>
  void each_alive(Use use) const {
    for (const Claim& claim : claims_) {
      if (claim.alive) use(claim);
    }
  }

  /// Forgets claims that ended before; returns true if nothing is left that has to be remembered.
  bool forget_before(Time before);

 private:
  Claim* of(const Speaker& speaker);
  NodeId node() const;
  bool may_be_believed(const Claim& claim, Time now) const;
  Claim* believed(Time now);
  void compare(Time now);
  void refuse_contested(Time now);
  void prefer_vouched(Time now);
  void settle(Time now);
  std::vector<LinkId> silent_links(const Claim& believed, Time now) const;
  bool speaks(const Claim& claim, Time now) const;
  template <class Which>
  void drop(Which which);

  const ClaimContext& context_;
  std::vector<Claim> claims_;  ///< in the order in which they came, but untrue ones are last
  /// Since when the believed speaker does not say that its node lives, while another one does.
  std::optional<Time> doubted_since_{};
  /// The speaker with whose claim all others were compared as they are. A comparison copies, and a node with
  /// two links has two claims for most endpoints.
  std::optional<Speaker> compared_with_{};
  ToldEndpoint told_;
};

}  // namespace sft::core
